/* outlines.c: writes src/render/outlines.h from a TrueType font, Debian's fonts-open-sans.
 *   cc scripts/outlines.c $(pkg-config --cflags --libs freetype2) -o outlines
 *   ./outlines /usr/share/fonts/truetype/open-sans/OpenSans-Regular.ttf
 * >src/render/outlines.h */
#include <ft2build.h>
#include FT_FREETYPE_H
#include FT_OUTLINE_H
#include <stdio.h>
#include <string.h>

enum { OFFSET = 700, BASE = 56, LINE = 88 }; /* numbers from -700 to 2435, in two letters each */

static char glyph[4096];
static size_t length;

/* '#' to '[' without '?', of which two would begin a trigraph. */
static char letter(long digit) { return (char)('#' + digit + ('#' + digit >= '?')); }

static void put(char op, const FT_Vector *points, int count) {
    if (op) glyph[length++] = op;
    for (int i = 0; i < count; ++i) {
        const long numbers[2] = {points[i].x + OFFSET, points[i].y + OFFSET};
        for (int k = 0; k < 2; ++k) {
            glyph[length++] = letter(numbers[k] / BASE);
            glyph[length++] = letter(numbers[k] % BASE);
        }
    }
}

static int move_to(const FT_Vector *to, void *user) { return (void)user, put('m', to, 1), 0; }
static int line_to(const FT_Vector *to, void *user) { return (void)user, put('l', to, 1), 0; }
static int curve_to(const FT_Vector *by, const FT_Vector *to, void *user) {
    const FT_Vector both[2] = {*by, *to};
    return (void)user, put('q', both, 2), 0;
}
static int cubic_to(const FT_Vector *a, const FT_Vector *b, const FT_Vector *to, void *user) {
    return (void)a, (void)b, (void)to, (void)user, 1;
}

static int write_glyph(FT_Face face, unsigned long character) {
    static const FT_Outline_Funcs parts = {move_to, line_to, curve_to, cubic_to, 0, 0};
    length = 0;
    if (!FT_Get_Char_Index(face, character) || FT_Load_Char(face, character, FT_LOAD_NO_SCALE))
        return 1;
    const FT_Vector advance = {face->glyph->metrics.horiAdvance, 0};
    put(0, &advance, 1);
    if (FT_Outline_Decompose(&face->glyph->outline, &parts, NULL)) return 1;
    for (size_t at = 0; at < length; at += LINE) {
        const size_t rest = length - at;
        printf("%s\"%.*s\"", at ? "\n        " : "", (int)(rest < LINE ? rest : LINE), glyph + at);
    }
    return 0;
}

int main(int count, char **words) {
    FT_Library library;
    FT_Face face;
    if (count != 2 || FT_Init_FreeType(&library) || FT_New_Face(library, words[1], 0, &face))
        return 2;
    printf(
        "/* outlines.h: the outlines of letters: %s %s, made by scripts/outlines.c.\n *\n"
        " * Digitized data copyright (c) 2010-2011, Google Corporation. Licensed under the Apache\n"
        " * License, Version 2.0 (the \"License\"); you may not use this file except in compliance "
        "with\n"
        " * the License. You may obtain a copy of the License at\n"
        " * http://www.apache.org/licenses/LICENSE-2.0\n"
        " * Unless required by applicable law or agreed to in writing, software distributed under "
        "the\n"
        " * License is distributed on an \"AS IS\" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF ANY "
        "KIND,\n"
        " * either express or implied. See the License for the specific language governing "
        "permissions\n"
        " * and limitations under the License.\n *\n"
        " * A glyph is a point, its advance, then m (to a point), l (a line to it) or q (a "
        "quadratic\n"
        " * curve by one to another). A point is two numbers, x to the right and y upwards; each "
        "has two\n"
        " * letters: digits from '#' without '?', to the base of RENDER_OUTLINE_BASE, less\n"
        " * RENDER_OUTLINE_OFFSET. */\n"
        "#ifndef NORMA_RENDER_OUTLINES_H\n#define NORMA_RENDER_OUTLINES_H\n#include <stdint.h>\n\n"
        "/* clang-format off */\n",
        face->family_name, face->style_name);
    if (FT_Load_Char(face, 'H', FT_LOAD_NO_SCALE)) return 1;
    printf("enum {\n    RENDER_FIRST_OUTLINE = 32,\n    RENDER_OUTLINES = 95,\n    "
           "RENDER_OUTLINE_BASE = %d,\n"
           "    RENDER_OUTLINE_OFFSET = %d,\n    RENDER_CAPITALS = %ld /* their height */\n};\n\n",
        BASE, OFFSET, (long)face->glyph->metrics.height);
    printf("static const char *const render_outlines[RENDER_OUTLINES] = {\n");
    for (unsigned long c = 32; c < 127; ++c) {
        printf("    ");
        if (write_glyph(face, c)) return 1;
        printf(",\n");
    }
    printf("};\n\nstatic const struct render_extra_outline {\n    uint32_t character;\n    const "
           "char *glyph;\n"
           "} render_extra_outlines[] = {\n");
    const unsigned long extra[] = {0xB0, 0xD7, 0x2212};
    for (int i = 0; i < 3; ++i) {
        printf("    {0x%lX,\n        ", extra[i]);
        if (write_glyph(face, extra[i])) return 1;
        printf("},\n");
    }
    printf("};\n/* clang-format on */\n#endif\n");
    return 0;
}
