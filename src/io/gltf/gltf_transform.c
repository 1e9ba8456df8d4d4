/* gltf_transform.c: a matrix over an asset, node transforms baked into meshes, and meshes moved
 * near their origin. Begin at norma_gltf_transform, at the end. */
#include "io/gltf/gltf_layout.h"
#include <stdlib.h>
#include <string.h>

/* ---- What is known of nodes before any is baked: which are animated, joints, or hold
 * more than a mesh. */

/* For each node of the file. */
enum {
    BAKE_MOVES = 1,      /* an animation moves it */
    BAKE_WEIGHTS = 2,    /* an animation sets its morph weights */
    BAKE_MOVED = 4,      /* it or a node above it is moved */
    BAKE_JOINT = 8,      /* of a skin, or its skeleton */
    BAKE_HOLDS_MORE = 16 /* a camera, a light, an extension that may depend on where the node is */
};

/* Parents before their children; NULL: out of memory; to be freed. */
static uint32_t *gltf_bake_order(const gltf *g, const gltf_tree *tree) {
    uint32_t *order =
        tree->nodes ? norma_io_allocate((size_t)g->node_count + 1, sizeof *order) : NULL;
    uint32_t count = 0;
    for (uint32_t i = 0; order && i < g->node_count; ++i)
        if (tree->nodes[i].parent == GLTF_NONE) order[count++] = i;
    for (uint32_t at = 0; order && at < count; ++at)
        for (uint32_t child = tree->nodes[order[at]].first;
             child != GLTF_NONE && count < g->node_count; child = tree->nodes[child].after)
            order[count++] = child;
    return order;
}

static void flag_node(const gltf *g, unsigned char *flags, uint32_t token, unsigned flag) {
    const uint32_t node = norma_gltf_number(g, token, g->node_count);
    if (node != GLTF_NONE) flags[node] = (unsigned char)(flags[node] | flag);
}

/* KHR_animation_pointer: "/nodes/7/rotation". */
static void flag_pointer(const gltf *g, unsigned char *flags, uint32_t target) {
    const uint32_t extension = norma_gltf_extension(g, target, "KHR_animation_pointer");
    char *pointer = norma_json_string(&g->json, norma_json_member(&g->json, extension, "pointer"));
    if (pointer && strncmp(pointer, "/nodes/", 7) == 0) {
        char *end;
        const unsigned long number = strtoul(pointer + 7, &end, 10);
        if (end != pointer + 7 && number < g->node_count) {
            const int moves = strcmp(end, "/translation") == 0 || strcmp(end, "/rotation") == 0 ||
                              strcmp(end, "/scale") == 0 || strcmp(end, "/matrix") == 0;
            if (moves)
                flags[number] |= BAKE_MOVES;
            else if (strncmp(end, "/weights", 8) == 0)
                flags[number] |= BAKE_WEIGHTS;
        }
    }
    free(pointer);
}

static void flag_animations(const gltf *g, unsigned char *flags) {
    const json *j = &g->json;
    const uint32_t animations = norma_json_member(j, 0, "animations");
    for (uint32_t animation = JSON_NONE; norma_json_each(j, animations, &animation);) {
        const uint32_t channels = norma_json_member(j, animation, "channels");
        for (uint32_t channel = JSON_NONE; norma_json_each(j, channels, &channel);) {
            const uint32_t target = norma_json_member(j, channel, "target"),
                           path = norma_json_member(j, target, "path");
            if (norma_json_equals(j, path, "pointer"))
                flag_pointer(g, flags, target);
            else
                flag_node(g, flags, norma_json_member(j, target, "node"),
                    norma_json_equals(j, path, "weights") ? BAKE_WEIGHTS : BAKE_MOVES);
        }
    }
}

static void flag_skins(const gltf *g, unsigned char *flags) {
    const json *j = &g->json;
    const uint32_t skins = norma_json_member(j, 0, "skins");
    for (uint32_t skin = JSON_NONE; norma_json_each(j, skins, &skin);) {
        const uint32_t joints = norma_json_member(j, skin, "joints");
        flag_node(g, flags, norma_json_member(j, skin, "skeleton"), BAKE_JOINT);
        for (uint32_t joint = JSON_NONE; norma_json_each(j, joints, &joint);)
            flag_node(g, flags, joint, BAKE_JOINT);
    }
}

/* Extensions of a node that say nothing about where it is. */
static const char *const placeless[] = {"EXT_mesh_gpu_instancing", "KHR_node_visibility",
    "KHR_node_selectability", "KHR_node_hoverability", "KHR_xmp_json_ld", "KHR_xmp", NULL};

static int holds_more(const gltf *g, uint32_t node) {
    const uint32_t token = g->nodes[node].token;
    return norma_json_member(&g->json, token, "camera") != JSON_NONE ||
           norma_gltf_extends_beyond(g, token, placeless);
}

/* NULL: out of memory; to be freed */
static unsigned char *gltf_bake_flags(const gltf *g, const uint32_t *order) {
    unsigned char *flags = norma_io_allocate((size_t)g->node_count + 1, 1);
    if (!flags) return NULL;
    flag_animations(g, flags);
    flag_skins(g, flags);
    for (uint32_t i = 0; i < g->node_count; ++i) {
        const uint32_t node = order[i], parent = g->nodes[node].parent;
        if (holds_more(g, node)) flags[node] |= BAKE_HOLDS_MORE;
        if ((flags[node] & BAKE_MOVES) || (parent != GLTF_NONE && (flags[parent] & BAKE_MOVED)))
            flags[node] |= BAKE_MOVED;
    }
    return flags;
}

/* NULL, or why a mesh cannot be transformed. */
static const char *gltf_bake_obstacle(const gltf *g, uint32_t mesh) {
    for (uint32_t i = 0; i < g->meshes[mesh].primitive_count; ++i) {
        const gltf_primitive *primitive = &g->primitives[g->meshes[mesh].first_primitive + i];
        if (primitive->draco.token != GLTF_NONE && primitive->not_read)
            return "is compressed with KHR_draco_mesh_compression and cannot be read";
        if (norma_gltf_extension(g, primitive->token, "KHR_gaussian_splatting") != JSON_NONE)
            return "holds splats (KHR_gaussian_splatting)";
    }
    return NULL;
}

/* ---- --bake: the world matrix of every node that draws a mesh becomes the identity, the mesh
 * is transformed instead.
 *
 * A node that is baked stays where it hangs. Below a node that keeps its own world matrix it gets
 * the inverse of that (two nodes where it is sheared; where there is no inverse, it becomes a
 * root); below another baked node, and as a root, nothing. What hangs below it and keeps its world
 * matrix goes under a new node between them that holds the matrix which the baked node gave up. A
 * node that holds more than a mesh (a camera, a light, a joint) keeps its matrix, and a new node
 * below draws the mesh.
 *
 * The matrix that is applied after all node transforms is in the meshes that are baked. All else
 * that is somewhere (cameras, joints, animated nodes, meshes that stay, empty nodes) gets it by a
 * node above the roots. Where a root has nothing of that kind, its groups of baked nodes keep their
 * world matrices. */

typedef enum node_fate {
    FATE_KEEPS = 0,
    FATE_BAKED,
    FATE_PARTED
} node_fate; /* parted: keeps its matrix, its mesh goes to a new node */

typedef struct baked_node {
    uint32_t root;
    unsigned char fate, holds_baked; /* holds_baked: a node below it is */
    unsigned char under_matrix;      /* of a root: the matrix goes above it */
} baked_node;

typedef struct baked_mesh {
    uint32_t stays; /* how many nodes draw it that are not baked */
    int taken;      /* a baked node has it already, another one gets a copy */
} baked_mesh;

typedef struct baking {
    gltf *g;
    const norma_transform_options *options;
    norma_transform_summary *summary;
    gltf_tree tree;
    bake_cache cache;
    int moves; /* options->matrix is not the identity */
    uint32_t *order;
    unsigned char *flags;
    baked_node *nodes;
    baked_mesh *meshes;
    int instances_left; /* instances that stay */
    size_t uses, done;  /* meshes to be transformed */
} baking;

static int allocate_baking(baking *b) {
    b->order = gltf_bake_order(b->g, &b->tree);
    b->flags = b->order ? gltf_bake_flags(b->g, b->order) : NULL;
    b->nodes = norma_io_allocate(b->g->node_count, sizeof *b->nodes);
    b->meshes = norma_io_allocate(b->g->mesh_count, sizeof *b->meshes);
    return b->flags && b->nodes && b->meshes;
}

static void free_baking(baking *b) {
    norma_gltf_tree_free(&b->tree);
    norma_gltf_bake_cache_free(&b->cache);
    free(b->order);
    free(b->flags);
    free(b->nodes);
    free(b->meshes);
}

/* ---- who is baked */

static void note_stays(const baking *b, uint32_t node, const char *why) {
    const char *name = b->g->nodes[node].name;
    if (name && *name)
        norma_document_add_note(
            b->g->document, "node %u \"%s\" is not baked: %s", (unsigned)node, name, why);
    else
        norma_document_add_note(b->g->document, "node %u is not baked: %s", (unsigned)node, why);
}

/* NULL, or why a node that draws a mesh keeps it as it is. */
static const char *why_not(const baking *b, uint32_t node) {
    const gltf_node *n = &b->g->nodes[node];
    const unsigned flags = b->flags[node];
    if (n->skin != GLTF_NONE) return "its mesh is skinned, and follows its joints";
    if (flags & BAKE_MOVES) return "it is animated";
    if (flags & BAKE_MOVED) return "a node above it is animated";
    if ((flags & BAKE_WEIGHTS) && ((flags & (BAKE_HOLDS_MORE | BAKE_JOINT)) || n->instanced))
        return "its morph weights are animated, and it holds more than one mesh at one place";
    return NULL;
}

static node_fate fate_of(const baking *b, uint32_t node) {
    const gltf_node *n = &b->g->nodes[node];
    if (n->mesh == GLTF_NONE || (n->instanced && n->instances == 0)) return FATE_KEEPS;
    const char *obstacle = gltf_bake_obstacle(b->g, n->mesh), *why = why_not(b, node);
    if (why) {
        note_stays(b, node, why);
        return FATE_KEEPS;
    }
    if (obstacle) {
        norma_document_add_note(b->g->document, "node %u is not baked: mesh %u %s", (unsigned)node,
            (unsigned)n->mesh, obstacle);
        return FATE_KEEPS;
    }
    double world[16];
    norma_gltf_matrix_multiply(b->options->matrix, n->world, world);
    if (!n->instanced && norma_matrix_is_identity(world)) return FATE_KEEPS; /* nothing to bake */
    return b->flags[node] & (BAKE_HOLDS_MORE | BAKE_JOINT) ? FATE_PARTED : FATE_BAKED;
}

static void decide_fates(baking *b) {
    for (uint32_t i = 0; i < b->g->node_count; ++i) {
        const uint32_t node = b->order[i], parent = b->g->nodes[node].parent;
        b->nodes[node].fate = (unsigned char)fate_of(b, node);
        b->nodes[node].root = parent == GLTF_NONE ? node : b->nodes[parent].root;
        if (b->g->nodes[node].mesh == GLTF_NONE) continue;
        if (b->nodes[node].fate == FATE_KEEPS) {
            ++b->meshes[b->g->nodes[node].mesh].stays;
            b->instances_left |= b->g->nodes[node].instanced;
        } else {
            b->uses += b->g->nodes[node].instances;
            ++b->summary->nodes_baked;
        }
    }
}

/* Which roots hold something besides baked nodes and the groups above them. */
static void decide_under_matrix(baking *b) {
    for (uint32_t i = b->g->node_count; i-- > 0;) {
        const uint32_t node = b->order[i], parent = b->g->nodes[node].parent;
        const baked_node *of = &b->nodes[node];
        const int baked = of->fate == FATE_BAKED, draws = b->g->nodes[node].mesh != GLTF_NONE;
        if ((baked || of->holds_baked) && parent != GLTF_NONE) b->nodes[parent].holds_baked = 1;
        if (!baked && (draws || !of->holds_baked ||
                          (b->flags[node] & (BAKE_MOVES | BAKE_JOINT | BAKE_HOLDS_MORE))))
            b->nodes[of->root].under_matrix = 1;
    }
}

/* ---- the hierarchy */

/* The world matrix that a node which keeps its own will have. */
static void kept_world(const baking *b, uint32_t node, double world[16]) {
    memcpy(world, b->g->nodes[node].world, 16 * sizeof *world);
    if (b->moves && b->nodes[b->nodes[node].root].under_matrix)
        norma_gltf_matrix_multiply(b->options->matrix, world, world);
}

/* Brings node, a child of above, which keeps its world matrix, to the identity. */
static void hang_at_identity(baking *b, uint32_t node, uint32_t above) {
    double world[16], inverse[16], identity[16];
    kept_world(b, above, world);
    norma_gltf_matrix_identity(identity);
    if (norma_gltf_matrix_invert(world, inverse)) {
        norma_gltf_tree_set_local(&b->tree, node, inverse);
    } else {
        norma_gltf_tree_make_root(&b->tree, node);
        norma_gltf_tree_set_local(&b->tree, node, identity);
    }
}

/* Those of node's children that are not baked, under a new node that holds the matrix which node
 * gave up. */
static void keep_children(baking *b, uint32_t node) {
    uint32_t between = GLTF_NONE;
    for (uint32_t child = b->tree.nodes[node].first, after; child != GLTF_NONE && !b->tree.failed;
         child = after) {
        after = b->tree.nodes[child].after;
        if (b->nodes[child].fate == FATE_BAKED) continue;
        if (between == GLTF_NONE) between = norma_gltf_tree_add(&b->tree, GLTF_NONE);
        if (between != GLTF_NONE) norma_gltf_tree_give(&b->tree, child, between);
    }
    if (between == GLTF_NONE || b->tree.failed) return;
    double world[16];
    kept_world(b, node, world);
    norma_gltf_tree_give(&b->tree, between, node);
    norma_gltf_tree_set_local(&b->tree, between, world);
}

static void rehang_baked(baking *b, uint32_t node) {
    const uint32_t parent = b->g->nodes[node].parent;
    double identity[16];
    norma_gltf_matrix_identity(identity);
    keep_children(b, node);
    if (parent == GLTF_NONE || b->nodes[parent].fate == FATE_BAKED)
        norma_gltf_tree_set_local(&b->tree, node, identity);
    else
        hang_at_identity(b, node, parent);
}

/* The matrix above the roots: all of them or, baking, those that hold something it must move and
 * are not baked themselves, which have it in what keep_children made. A skinned mesh goes by its
 * joints: one without children stays a root, as validators want it. */
static norma_document_result raise_roots_of(gltf_tree *tree, const baked_node *nodes,
    const double matrix[16], norma_document_error *error) {
    const gltf *g = tree->g;
    unsigned char *wanted = norma_io_allocate((size_t)g->node_count + 1, 1);
    if (!wanted) return norma_document_fail_memory(g->document, error);
    for (uint32_t i = 0; !tree->failed && i < g->node_count; ++i)
        wanted[i] = (!nodes || (nodes[i].under_matrix && nodes[i].fate != FATE_BAKED)) &&
                    !(g->nodes[i].skin != GLTF_NONE && tree->nodes[i].first == GLTF_NONE);
    norma_gltf_tree_raise(tree, wanted, matrix);
    free(wanted);
    return NORMA_DOCUMENT_OK;
}

/* ---- the meshes */

/* A mesh of its own for holder, transformed by world. */
static norma_document_result bake_use(baking *b, uint32_t node, uint32_t holder,
    const double world[16], norma_document_error *error) {
    gltf *g = b->g;
    const uint32_t mesh = g->nodes[node].mesh;
    uint32_t copy = 0, number = mesh;
    bake_map map;
    const int is_copy = b->meshes[mesh].stays || b->meshes[mesh].taken;
    if (is_copy) copy = norma_gltf_copy_mesh(g, mesh, &number);
    if ((is_copy && !copy) || !norma_gltf_bake_map(&b->cache, world, &map))
        return norma_document_fail_memory(g->document, error);
    b->meshes[mesh].taken = 1;
    b->tree.nodes[holder].mesh_changed = holder >= g->node_count || number != mesh;
    b->tree.nodes[holder].mesh = number;
    ++b->summary->meshes;
    b->summary->mirrored |= map.mirrored;
    if (map.rank < 2)
        norma_document_add_note(g->document,
            "node %u: its matrix flattens everything to %s, which has no normal; normals became +Z",
            (unsigned)node, map.rank ? "a line" : "a point");
    const mesh_use use = {mesh, copy, node};
    const norma_document_result result =
        norma_gltf_bake_mesh(g, &b->cache, &use, &map, &b->summary->vertices, error);
    ++b->done;
    if (!result && b->options->progress &&
        b->options->progress(b->options->progress_user, (double)b->done / (double)b->uses))
        return norma_document_fail_core(g->document, error, NORMA_CANCELLED);
    return result;
}

/* Their accessors are given up: each instance becomes a node. */
static norma_document_result take_instances(
    gltf *g, uint32_t node, gltf_instances *instances, norma_document_error *error) {
    norma_document_result result = norma_gltf_read_instances(g, node, instances, error);
    const uint32_t attributes = instances->attributes;
    for (uint32_t value = JSON_NONE; !result && norma_json_each(&g->json, attributes, &value);) {
        const uint32_t accessor = norma_gltf_number(g, value, g->accessor_count);
        if (accessor != GLTF_NONE && !norma_gltf_release(g, accessor))
            result = norma_document_fail_memory(g->document, error);
    }
    if (norma_json_size(&g->json, attributes) >
        (uint32_t)((instances->translation.width > 0) + (instances->rotation.width > 0) +
                   (instances->scale.width > 0)))
        norma_document_add_note(g->document,
            "node %u: other attributes of its instances (such as _ID) cannot be stored in separate "
            "meshes and are dropped",
            (unsigned)node);
    return result;
}

/* One mesh for each instance: the first at holder, the others at new nodes below it. */
static norma_document_result bake_instances(baking *b, uint32_t node, uint32_t holder,
    const double world[16], norma_document_error *error) {
    gltf_instances instances = {0};
    norma_document_result result = take_instances(b->g, node, &instances, error);
    b->tree.nodes[node].instances_removed = 1;
    for (size_t i = 0; !result && i < b->g->nodes[node].instances; ++i) {
        double matrix[16];
        norma_gltf_instance_matrix(&instances, i, matrix);
        norma_gltf_matrix_multiply(world, matrix, matrix);
        uint32_t at = holder;
        if (i > 0) {
            at = norma_gltf_tree_add(&b->tree, node);
            if (at == GLTF_NONE) return norma_document_fail_memory(b->g->document, error);
            b->tree.nodes[at].takes_weights = 1;
            norma_gltf_tree_give(&b->tree, at, holder);
        }
        result = bake_use(b, node, at, matrix, error);
    }
    return result;
}

/* The new node below a parted one that draws its mesh. */
static uint32_t part(baking *b, uint32_t node) {
    const uint32_t holder = norma_gltf_tree_add(&b->tree, node);
    if (holder == GLTF_NONE) return GLTF_NONE;
    b->tree.nodes[holder].takes_weights = 1;
    b->tree.nodes[node].weights_removed = 1;
    b->tree.nodes[node].mesh_changed = 1;
    norma_gltf_tree_give(&b->tree, holder, node);
    hang_at_identity(b, holder, node);
    return holder;
}

static norma_document_result bake_node(baking *b, uint32_t node, norma_document_error *error) {
    double world[16];
    norma_gltf_matrix_multiply(b->options->matrix, b->g->nodes[node].world, world);
    uint32_t holder = node;
    if (b->nodes[node].fate == FATE_BAKED)
        rehang_baked(b, node);
    else
        holder = part(b, node);
    if (holder == GLTF_NONE || b->tree.failed)
        return norma_document_fail_memory(b->g->document, error);
    return b->g->nodes[node].instanced ? bake_instances(b, node, holder, world, error)
                                       : bake_use(b, node, holder, world, error);
}

static norma_document_result unlist_instancing(baking *b, norma_document_error *error) {
    int removed = 0;
    for (uint32_t i = 0; i < b->g->node_count; ++i) removed |= b->tree.nodes[i].instances_removed;
    if (!removed || b->instances_left || norma_gltf_unlist(b->g, "EXT_mesh_gpu_instancing"))
        return NORMA_DOCUMENT_OK;
    return norma_document_fail_memory(b->g->document, error);
}

static norma_document_result bake_all(baking *b, norma_document_error *error) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    decide_fates(b);
    decide_under_matrix(b);
    for (uint32_t i = 0; !result && i < b->g->node_count; ++i)
        if (b->nodes[b->order[i]].fate != FATE_KEEPS) result = bake_node(b, b->order[i], error);
    if (!result && b->moves) result = raise_roots_of(&b->tree, b->nodes, b->options->matrix, error);
    if (!result) result = unlist_instancing(b, error);
    return result ? result : norma_gltf_tree_write(&b->tree, error);
}

static norma_document_result gltf_bake(gltf *g, const norma_transform_options *options,
    norma_transform_summary *summary, norma_document_error *error) {
    baking b = {.g = g,
        .options = options,
        .summary = summary,
        .moves = !norma_matrix_is_identity(options->matrix)};
    norma_gltf_tree_read(g, &b.tree);
    norma_document_result result = b.tree.failed || !allocate_baking(&b)
                                       ? norma_document_fail_memory(g->document, error)
                                       : bake_all(&b, error);
    free_baking(&b);
    return result;
}

/* ---- Positions of a glTF mesh brought near its origin; each node that drew it gets a
 * node below it, which draws it now and says how far it was moved: whatever moves the node, and
 * whatever else hangs on it, is as it was. */

typedef struct recentring {
    gltf *g;
    gltf_tree tree;
    unsigned char *flags; /* of nodes */
    unsigned char *moved; /* of meshes */
    double (*steps)[3];
} recentring;

/* ---- which meshes can be moved */

/* Where skins, instances or animated weights hang on the node that draws a mesh, another node
 * cannot take it over. */
static const char *obstacle_of(const recentring *r, uint32_t mesh) {
    const gltf *g = r->g;
    const char *obstacle = gltf_bake_obstacle(g, mesh);
    for (uint32_t i = 0; i < g->drawing_count && !obstacle; ++i) {
        const gltf_node *node = &g->nodes[g->drawing[i]];
        if (node->mesh == mesh)
            obstacle = node->skin != GLTF_NONE                  ? "is drawn with a skin"
                       : node->instanced                        ? "is drawn by instancing"
                       : r->flags[g->drawing[i]] & BAKE_WEIGHTS ? "has animated weights"
                                                                : NULL;
    }
    return obstacle ? obstacle : g->meshes[mesh].uses == 0 ? "is drawn by no node" : NULL;
}

static int is_float(const gltf *g, uint32_t accessor) {
    return accessor != GLTF_NONE && g->accessors[accessor].component == GLTF_FLOAT &&
           g->accessors[accessor].width == 3;
}

static norma_document_result measure_offset(
    recentring *r, uint32_t mesh, int *fits, norma_document_error *error) {
    gltf *g = r->g;
    recentre_box box = norma_recentre_empty();
    *fits = 1;
    for (uint32_t i = 0; i < g->meshes[mesh].primitive_count && *fits; ++i) {
        const gltf_primitive *p = &g->primitives[g->meshes[mesh].first_primitive + i];
        gltf_array array;
        *fits = is_float(g, p->base.position);
        norma_document_result result =
            *fits ? norma_gltf_array(g, p->base.position, &array, error) : NORMA_DOCUMENT_OK;
        if (result) return result;
        for (size_t v = 0; *fits && v < array.count; ++v) {
            double element[3];
            norma_gltf_doubles(&array, v, element);
            norma_recentre_add(&box, element);
        }
    }
    *fits = *fits && norma_recentre_step(&box, r->steps[mesh]);
    return NORMA_DOCUMENT_OK;
}

/* ---- moving one */

static norma_document_result move_mesh_positions(
    recentring *r, uint32_t primitive, const double step[3], norma_document_error *error) {
    gltf *g = r->g;
    gltf_array array;
    gltf_data data;
    norma_document_result result =
        norma_gltf_array(g, g->primitives[primitive].base.position, &array, error);
    double *values = result ? NULL : norma_io_allocate(array.count + 1, 3 * sizeof *values);
    if (!values) return result ? result : norma_document_fail_memory(g->document, error);
    for (size_t v = 0; v < array.count; ++v) {
        norma_gltf_doubles(&array, v, values + 3 * v);
        for (size_t axis = 0; axis < 3; ++axis) values[3 * v + axis] -= step[axis];
    }
    const bake_encoded encoded = norma_gltf_encode(BAKE_POSITIONS, &array, values, &data);
    free(values);
    if (encoded) return norma_document_fail_memory(g->document, error);
    data.bounds = 1;
    const gltf_slot slot = {
        .primitive = primitive, .target = GLTF_SLOT_BASE, .attribute = "POSITION"};
    return norma_gltf_put_new(g, &slot, &data, error);
}

static void move_node(gltf_tree *tree, uint32_t node, const double step[3]) {
    const double local[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, step[0], step[1], step[2], 1};
    const uint32_t below = norma_gltf_tree_add(tree, node);
    if (below == GLTF_NONE) return;
    tree->nodes[below].mesh = tree->g->nodes[node].mesh;
    tree->nodes[below].takes_weights = tree->nodes[node].weights_removed = 1;
    tree->nodes[node].mesh = GLTF_NONE;
    tree->nodes[node].mesh_changed = 1;
    norma_gltf_tree_set_local(tree, below, local);
    norma_gltf_tree_give(tree, below, node);
}

static norma_document_result move_mesh(recentring *r, uint32_t mesh, norma_document_error *error) {
    gltf *g = r->g;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t i = 0; i < g->meshes[mesh].primitive_count && !result; ++i)
        result = move_mesh_positions(r, g->meshes[mesh].first_primitive + i, r->steps[mesh], error);
    for (uint32_t i = 0; i < g->drawing_count && !result; ++i)
        if (g->nodes[g->drawing[i]].mesh == mesh)
            move_node(&r->tree, g->drawing[i], r->steps[mesh]);
    return result;
}

/* ---- all of them */

static norma_document_result move_meshes(recentring *r, int *changed, norma_document_error *error) {
    gltf *g = r->g;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t mesh = 0; mesh < g->mesh_count && !result; ++mesh) {
        const char *obstacle = r->moved[mesh] ? obstacle_of(r, mesh) : NULL;
        int fits = 0;
        if (obstacle)
            norma_document_add_note(
                g->document, "mesh %u %s: its origin stays where it is", mesh, obstacle);
        else if (r->moved[mesh])
            result = measure_offset(r, mesh, &fits, error);
        if (!result && fits) result = move_mesh(r, mesh, error);
        *changed |= fits;
    }
    return result || !*changed ? result : norma_gltf_tree_write(&r->tree, error);
}

norma_document_result norma_gltf_recentre(
    norma_document *document, const uint8_t *meshes, int *changed, norma_document_error *error) {
    recentring r = {.g = norma_gltf_of(document)};
    norma_document_result result = NORMA_DOCUMENT_OK;
    norma_gltf_begin_change(r.g);
    norma_gltf_tree_read(r.g, &r.tree);
    uint32_t *order = gltf_bake_order(r.g, &r.tree);
    r.flags = order ? gltf_bake_flags(r.g, order) : NULL;
    r.moved = norma_io_allocate((size_t)r.g->mesh_count + 1, 1);
    r.steps = norma_io_allocate((size_t)r.g->mesh_count + 1, sizeof *r.steps);
    if (!r.flags || !r.moved || !r.steps || r.tree.failed)
        result = norma_document_fail_memory(document, error);
    for (uint32_t i = 0; i < r.g->primitive_count && !result; ++i)
        r.moved[r.g->primitives[i].mesh] |= !meshes || meshes[i];
    if (!result) result = move_meshes(&r, changed, error);
    if (!result && *changed) result = norma_gltf_finish(r.g, error);
    norma_gltf_tree_free(&r.tree);
    free(order);
    free(r.flags);
    free(r.moved);
    free(r.steps);
    return result;
}

/* ---- A matrix over a glTF. Without baking it becomes a node above the scenes' roots,
 * and no mesh is touched: animations, skins and instances follow by themselves. Baking is above.
 */

/* What a node's matrix may be off from translation, rotation and scale: columns perpendicular to a
 * relative 1e-5, as norma_kind has it. */
static const double shear_tolerance = 1e-5;

static norma_document_result check_matrix(
    const gltf *g, const double matrix[16], norma_document_error *error) {
    gltf_trs trs;
    const double shear = norma_gltf_matrix_decompose(matrix, &trs);
    if (shear > shear_tolerance)
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "the matrix is sheared, which no glTF node can hold; expected translation, rotation "
            "and scale, or baking (--bake)");
    return NORMA_DOCUMENT_OK;
}

/* What is drawn by some node is what the matrix acts on. */
static void count_drawn(const gltf *g, norma_transform_summary *summary) {
    for (uint32_t i = 0; i < g->mesh_count; ++i) {
        if (g->meshes[i].uses == 0) continue;
        ++summary->meshes;
        for (uint32_t k = 0; k < g->meshes[i].primitive_count; ++k)
            summary->vertices += g->primitives[g->meshes[i].first_primitive + k].vertices;
    }
}

static norma_document_result raise_all(
    gltf *g, const double matrix[16], norma_document_error *error) {
    gltf_tree tree;
    norma_gltf_tree_read(g, &tree);
    norma_document_result result = raise_roots_of(&tree, NULL, matrix, error);
    if (!result) result = norma_gltf_tree_write(&tree, error);
    norma_gltf_tree_free(&tree);
    return result;
}

norma_document_result norma_gltf_transform(norma_document *document,
    const norma_transform_options *options, norma_transform_summary *summary,
    norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    norma_matrix_info info;
    norma_document_result result = NORMA_DOCUMENT_OK;
    double normal[9];
    norma_gltf_begin_change(g);
    norma_normal_matrix_double(options->matrix, NORMA_WINDING_KEPT, normal, &info);
    summary->mirrored = info.mirrored;
    if (g->node_count == 0) {
        norma_document_add_note(document, "no node draws anything: there is nothing to transform");
    } else if (options->bake) {
        result = gltf_bake(g, options, summary, error);
    } else if (!norma_matrix_is_identity(options->matrix)) {
        result = check_matrix(g, options->matrix, error);
        count_drawn(g, summary);
        if (!result) result = raise_all(g, options->matrix, error);
    }
    if (!result) result = norma_gltf_finish(g, error);
    summary->changed = g->changed;
    return result;
}
