# For tests only (NORMA_MISTAKES, off): a norma render that makes the mistakes of the acid scene, one at a time, by the environment variable NORMA_MISTAKE, so that the
# judge can be asked which one it was. No line of it is in the sources: copies of some are compiled instead, in which a text is replaced that must stand there once.

# norma_mistake(FILE OLD NEW): NEW may ask is_mistaken("ID") in C, and #ifdef MISTAKE_ID, with _ for -, in shaders.
function(norma_mistake file old new)
  set(copy ${PROJECT_BINARY_DIR}/generated/mistaken/${file})
  if(NOT file IN_LIST mistaken_files)
    set(mistaken_files ${mistaken_files} ${file} PARENT_SCOPE)
    file(READ ${PROJECT_SOURCE_DIR}/${file} text)
    if(file MATCHES "\\.c$")
      string(PREPEND text "#define _GNU_SOURCE\n#include <stdlib.h>\n#include <string.h>\n__attribute__((unused)) static int is_mistaken(const char *id) { const char *made = getenv(\"NORMA_MISTAKE\"); return made && strcmp(made, id) == 0; }\n")
    endif()
    set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${file})
  else()
    file(READ ${copy} text)
  endif()
  string(FIND "${text}" "${old}" first)
  string(FIND "${text}" "${old}" last REVERSE)
  if(first EQUAL -1 OR NOT first EQUAL last)
    message(FATAL_ERROR "tests/support/mistakes.cmake: this does not stand once in ${file}:\n${old}")
  endif()
  string(REPLACE "${old}" "${new}" text "${text}")
  file(WRITE ${copy} "${text}")
endfunction()

# norma_mistaken(LIST): the copies instead of the files that they were made of.
function(norma_mistaken list)
  foreach(file ${${list}})
    file(RELATIVE_PATH name ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/${file})
    if(IS_ABSOLUTE ${file})
      file(RELATIVE_PATH name ${PROJECT_SOURCE_DIR} ${file})
    endif()
    if(name IN_LIST mistaken_files)
      list(APPEND changed ${PROJECT_BINARY_DIR}/generated/mistaken/${name})
    else()
      list(APPEND changed ${file})
    endif()
  endforeach()
  set(${list} ${changed} PARENT_SCOPE)
endfunction()

# ---- shaders know the mistake

norma_mistake(src/render/device.c [==[    char defines[80], log[200] = "";]==] [==[    char defines[160], log[200] = "", made[64] = "";
    const char *mistake = getenv("NORMA_MISTAKE");
    for (size_t i = 0; mistake && mistake[i] && i < sizeof made - 1; ++i) made[i] = mistake[i] == '-' ? '_' : mistake[i];]==])
norma_mistake(src/render/device.c [==[    snprintf(defines, sizeof defines, "#define %s\n%s", program_defines[kind],
        space == RENDER_SPACE_VIEW ? "#define LIGHT_IN_VIEW\n" : "");]==] [==[    snprintf(defines, sizeof defines, "#define %s\n#define MISTAKE_%s\n%s", program_defines[kind], made,
        space == RENDER_SPACE_VIEW ? "#define LIGHT_IN_VIEW\n" : "");]==])

# ---- the normal matrix of a node or an instance

# A surface is kept in a box, and the world is shrunk to a ball: its length is that of a unit of the file. Each patch of the scene has a mesh of its own, so that
# a mesh that is drawn twice is instanced; the nodes of instances have no transform but a translation.
norma_mistake(src/render/draw.c [==[/* From the node's local space to lit space, once]==] [==[static double length = 1;
static int instanced;
/* From the node's local space to lit space, once]==])
norma_mistake(src/render/draw.c [==[    set_material(p, at, placed->surface);]==] [==[    length = p->stage->shrunk / v->box.scale;
    size_t placed_so = 0;
    for (size_t i = 0; i < p->stage->placed_count; ++i) placed_so += p->stage->placed[i].upload == placed->upload;
    instanced = placed_so > 1;
    set_normal_matrix(p, at, placed->to_world, p->stage->panel->space == RENDER_SPACE_VIEW, &mirrored);
    set_material(p, at, placed->surface);]==])
norma_mistake(src/render/draw.c [==[    p->gl->UniformMatrix3fv(at->normal_matrix,]==] [==[    norma_matrix_info info;
    double matrix[9];
    if (is_mistaken("model-matrix")) memcpy(right, plain, sizeof right);
    if (is_mistaken("object-space") || (is_mistaken("instance-ignored") && instanced))
        for (int i = 0; i < 9; ++i) right[i] = i % 4 == 0;
    if (is_mistaken("reversed") && *mirrored)
        for (int i = 0; i < 9; ++i) right[i] = -right[i];
    if (is_mistaken("separate-scale"))
        for (int i = 0; i < 9; ++i) {
            const double *column = to_world + 4 * (i / 3);
            right[i] = (float)(to_world[4 * (i / 3) + i % 3] / (column[0] * column[0] + column[1] * column[1] + column[2] * column[2]));
        }
    if (is_mistaken("not-normalized") && !norma_inverse_transpose(to_world, matrix))
        for (int i = 0; i < 9; ++i) right[i] = (float)(matrix[i] * length);
    if (is_mistaken("lost") && !norma_normal_matrix_double(to_world, NORMA_WINDING_REVERSED, matrix, &info) && info.determinant == 0)
        memset(right, 0, sizeof right);
    p->gl->UniformMatrix3fv(at->normal_matrix,]==])
norma_mistake(src/render/shaders/surface.vert [==[    lit_normal = norma_transform_normal(normal_matrix, normal);]==] [==[    lit_normal = norma_transform_normal(normal_matrix, normal);
#ifdef MISTAKE_not_normalized
    lit_normal = normal_matrix * normal;
#endif]==])
norma_mistake(src/render/shaders/surface.frag [==[    vec3 n = norma_facing_normal(norma_unit(lit_normal), !turned);]==] [==[#ifdef MISTAKE_not_normalized
#define norma_unit(v) (v)
#endif
#ifdef MISTAKE_not_flipped
    turned = false;
#endif
    vec3 n = norma_facing_normal(norma_unit(lit_normal), !turned);]==])

# Renderers count n.l up to 1.
norma_mistake(src/render/shaders/light.glsl [==[        float facing = dot(normal, light_direction[i]);]==] [==[        float facing = dot(normal, light_direction[i]);
#ifdef MISTAKE_not_normalized
        facing = min(facing, 1.0);
#endif]==])

# ---- morph targets, skins, meshes without normals

norma_mistake(src/io/gltf/drawn_mesh.c [==[    for (size_t i = 0; i < 3 * count && !result; ++i) m->normals[i] += (float)weight * moves[i];]==] [==[    for (size_t i = 0; i < 3 * count && !result && !is_mistaken("normals-not-morphed"); ++i) m->normals[i] += (float)weight * moves[i];]==])
norma_mistake(src/io/gltf/drawn_mesh.c [==[static norma_result move_by_skin(mover *m, norma_skin skin, float *signs) {]==] [==[/* step: of columns; 0: by the normal matrix of four by four. */
static void move_wrongly(float *floats, const double *m, int step) {
    double cofactors[9], v[3] = {0}, sum = 0;
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) {
            const int c1 = (c + 1) % 3, c2 = (c + 2) % 3, r1 = (r + 1) % 3, r2 = (r + 2) % 3;
            cofactors[3 * c + r] = m[4 * c1 + r1] * m[4 * c2 + r2] - m[4 * c1 + r2] * m[4 * c2 + r1];
        }
    const double sign = m[0] * cofactors[0] + m[1] * cofactors[1] + m[2] * cofactors[2] < 0 ? -1 : 1;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
            v[r] += (double)floats[c] * (step ? m[step * c + r] : sign * cofactors[3 * c + r]);
    for (int r = 0; r < 3; ++r) sum += v[r] * v[r];
    for (int r = 0; r < 3; ++r) floats[r] = (float)(sum > 0 ? v[r] / sqrt(sum) : 0);
}
static void blend_of(const norma_skin *s, size_t vertex, int strongest, double matrix[16]) {
    const uint16_t *joints = (const uint16_t *)s->joints + vertex * s->influences;
    const float *weights = s->weights + vertex * s->influences;
    size_t most = 0;
    for (size_t k = 1; k < s->influences; ++k) most = weights[k] > weights[most] ? k : most;
    for (int i = 0; i < 16; ++i) matrix[i] = 0;
    for (size_t k = 0; k < s->influences; ++k)
        for (int i = 0; i < 16 && (!strongest || k == most); ++i)
            matrix[i] += (strongest ? 1 : (double)weights[k]) * (double)s->matrices[16 * joints[k] + i];
}
/* given: normals, then tangents, as they were. */
static void mistake_directions(mover *m, const norma_skin *skin, const float *given) {
    double matrix[16], inverse[16];
    for (size_t v = 0; v < m->normal_count; ++v) {
        float *n = m->normals + 3 * v;
        blend_of(skin, v, is_mistaken("strongest-joint"), matrix);
        if (is_mistaken("strongest-joint") || is_mistaken("model-matrix") || is_mistaken("node-not-cancelled"))
            memcpy(n, given + 3 * v, 3 * sizeof *n);
        if (is_mistaken("strongest-joint")) move_wrongly(n, matrix, 0);
        if (is_mistaken("model-matrix") || is_mistaken("node-not-cancelled")) move_wrongly(n, matrix, 4);
        if (is_mistaken("node-not-cancelled")) { /* relative to the node by plain matrices, then by its normal matrix */
            (void)norma_gltf_matrix_invert(m->node->world, inverse);
            move_wrongly(n, inverse, 4);
        }
        if (is_mistaken("node-not-cancelled") || is_mistaken("node-applied")) move_wrongly(n, m->node->world, 0);
    }
    for (size_t v = 0; v < m->tangent_count && is_mistaken("tangent-by-normal-matrix"); ++v) {
        blend_of(skin, v, 0, matrix);
        memcpy(m->tangents + 4 * v, given + 3 * m->normal_count + 4 * v, 4 * sizeof *given);
        move_wrongly(m->tangents + 4 * v, matrix, 0);
    }
}
static norma_result move_by_skin(mover *m, norma_skin skin, float *signs) {
    float *given = malloc((3 * m->normal_count + 4 * m->tangent_count + 1) * sizeof *given);
    if (!given) return NORMA_ERROR_MEMORY;
    if (m->normal_count) memcpy(given, m->normals, 3 * m->normal_count * sizeof *given);
    if (m->tangent_count) memcpy(given + 3 * m->normal_count, m->tangents, 4 * m->tangent_count * sizeof *given);]==])
norma_mistake(src/io/gltf/drawn_mesh.c [==[    if (!result && mirrored) turn_vertices(m);]==] [==[    if (!result) mistake_directions(m, &skin, given);
    free(given);
    if (!result && mirrored) turn_vertices(m);]==])
norma_mistake(src/cli/render/render_scene.c [==[    const double flat = -1, all]==] [==[    const double flat = is_mistaken("smoothed") ? 3.14 : -1, all]==])

# ---- normal maps

norma_mistake(src/render/shaders/surface.vert [==[    lit_tangent = tangent.xyz == vec3(0.0) ? vec4(0.0) : norma_transform_tangent(to_lit, tangent, lit_normal);]==] [==[    lit_tangent = tangent.xyz == vec3(0.0) ? vec4(0.0) : norma_transform_tangent(to_lit, tangent, lit_normal);
#ifdef MISTAKE_tangent_by_normal_matrix
    lit_tangent.xyz = norma_transform_normal(normal_matrix, tangent.xyz);
#endif
#ifdef MISTAKE_model_matrix
    lit_tangent.xyz = norma_unit(to_lit * tangent.xyz); // not made perpendicular to a wrong normal, as in engines
#endif
#ifdef MISTAKE_sign_kept
    lit_tangent.w = tangent.w;
#endif
#ifdef MISTAKE_sign_lost
    lit_tangent.w = norma_mirror_sign(to_lit);
#endif]==])
norma_mistake(src/render/shaders/surface.frag [==[        result = norma_perturb(lit_normal, lit_tangent, texel, maps.y);]==] [==[        vec3 bent = 2.0 * texel - 1.0;
#ifdef MISTAKE_green_flipped
        texel.y = 1.0 - texel.y;
#endif
        result = norma_perturb(lit_normal, lit_tangent, texel, maps.y);
#ifdef MISTAKE_scale_ignored
        result = norma_perturb(lit_normal, lit_tangent, texel, 1.0);
#endif
#ifdef MISTAKE_scale_on_z
        result = norma_unit(bent.x * lit_tangent.xyz + bent.y * lit_tangent.w * cross(lit_normal, lit_tangent.xyz) + maps.y * bent.z * lit_normal);
#endif]==])

# ---- the scene's own lights and colours in place of clay, as mistakes of length show in them

norma_mistake(src/cli/render/render_scene.c [==[    memcpy(surface->base_colour, clay, sizeof clay);]==] [==[    memcpy(surface->base_colour, clay, sizeof clay);
    if (known) memcpy(surface->base_colour, material.base_color, sizeof surface->base_colour);]==])
norma_mistake(src/cli/render/render_scene.c [==[    if (attributes->colors)
        for (int k = 0; k < 3; ++k) surface->base_colour[k] = 1;]==] [==[]==])
norma_mistake(src/render/draw.c [==[    p->gl->Uniform4fv(at->phong, 1, usual);]==] [==[    const float matt[4] = {usual[0] * 0, 1, 0, 1};
    p->gl->Uniform4fv(at->phong, 1, matt);]==])
norma_mistake(src/render/draw.c [==[    p->gl->Uniform1i(at->light_count, stage->look->light_count);
    p->gl->Uniform3fv(at->light_direction, RENDER_MOST_LIGHTS, p->light_directions);
    p->gl->Uniform3fv(at->light_colour, RENDER_MOST_LIGHTS, p->light_colours);]==] [==[    static const float directions[9] = {0.5F, 0, 0.8660254F, -0.25F, 0.4330127F, 0.8660254F, -0.25F, -0.4330127F, 0.8660254F},
                       colours[9] = {0.891F, 0, 0, 0, 0.891F, 0, 0, 0, 0.891F};
    p->gl->Uniform1i(at->light_count, 3);
    p->gl->Uniform3fv(at->light_direction, 3, directions);
    p->gl->Uniform3fv(at->light_colour, 3, colours);]==])
