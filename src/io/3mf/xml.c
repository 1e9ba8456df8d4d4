/* xml.c: a strict reader of XML in UTF-8 without document types: what is not well-formed is
 * refused. Source: Extensible Markup Language 1.0, fifth edition; names may have any character
 * beyond ASCII. */
#include "io/3mf/3mf.h"
#include "io/text/text.h"
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static xml_event fail_xml(xml_reader *x, const char *wrong) {
    snprintf(x->wrong, sizeof x->wrong, "is not XML: %s", wrong);
    return XML_WRONG;
}

static xml_event refuse_encoding(xml_reader *x, const char *found) {
    snprintf(
        x->wrong, sizeof x->wrong, "expected UTF-8, the encoding of a 3MF; found %.40s", found);
    return XML_WRONG;
}

/* ---- characters */

static int is_xml_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

static int is_name_byte(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (unsigned char)c >= 0x80 ||
           (c >= '0' && c <= ':') || c == '_' || c == '-' || c == '.';
}

static int begins_name(char c) {
    return is_name_byte(c) && !(c >= '0' && c <= '9') && c != '-' && c != '.';
}

static int is_xml_character(uint32_t code) {
    return code >= 0x20 ? code < 0xD800 || (code >= 0xE000 && code < 0xFFFE) ||
                              (code >= 0x10000 && code <= 0x10FFFF)
                        : code == '\t' || code == '\n' || code == '\r';
}

/* &lt; and such: how many bytes of text it takes, and what it stands for; 0: no such. */
static size_t read_reference(const char *text, uint32_t *code) {
    static const struct {
        const char *name;
        char means;
    } entities[] = {
        {"&lt;", '<'}, {"&gt;", '>'}, {"&amp;", '&'}, {"&quot;", '"'}, {"&apos;", '\''}};
    for (size_t i = 0; i < sizeof entities / sizeof entities[0]; ++i) {
        const size_t length = strlen(entities[i].name);
        *code = (unsigned char)entities[i].means;
        if (strncmp(text, entities[i].name, length) == 0) return length;
    }
    if (text[1] != '#') return 0;
    const int is_hex = text[2] == 'x';
    const char *digits = is_hex ? "0123456789abcdefABCDEF" : "0123456789";
    const size_t first = is_hex ? 3 : 2, count = strspn(text + first, digits);
    if (!count || text[first + count] != ';') return 0;
    *code = 0;
    for (size_t i = first; i < first + count && *code <= 0x10FFFF; ++i) {
        const char c = text[i];
        const int digit = c <= '9' ? c - '0' : (c | 0x20) - 'a' + 10;
        *code = *code * (is_hex ? 16U : 10U) + (uint32_t)digit;
    }
    return is_xml_character(*code) ? first + count + 1 : 0;
}

/* ---- tags */

/* Where the tag at x->at ends, on its >; the end of the text: nowhere. */
static size_t tag_end(const xml_reader *x) {
    char quote = 0;
    size_t at = x->at;
    for (; at < x->size; ++at) {
        const char c = x->text[at];
        if (quote)
            quote = c == quote ? 0 : quote;
        else if (c == '"' || c == '\'')
            quote = c;
        else if (c == '>')
            break;
    }
    return at;
}

static size_t skip_xml_blanks(const xml_reader *x, size_t at) {
    while (is_xml_blank(x->text[at])) ++at;
    return at;
}

/* A name of the tag goes to the words, which have room for all of the tag; what is behind it there.
 * NULL: there is no name. */
static char *take_xml_name(xml_reader *x, char *word) {
    if (!begins_name(x->text[x->at])) return NULL;
    while (is_name_byte(x->text[x->at])) *word++ = x->text[x->at++];
    *word++ = '\0';
    return word;
}

/* The same for a value in quotes: blanks are spaces in it (chapter 3.3.3). */
static char *take_xml_value(xml_reader *x, char *word) {
    const char *text = x->text;
    const char quote = text[x->at];
    if (quote != '"' && quote != '\'') return NULL;
    for (++x->at; text[x->at] != quote;) {
        uint32_t code;
        size_t length = 1;
        if (text[x->at] == '<' || x->at >= x->size) return NULL;
        if (text[x->at] == '&') {
            length = read_reference(text + x->at, &code);
            if (!length) return NULL;
            word += norma_put_utf8(word, code);
        } else if (is_xml_blank(text[x->at])) {
            length += text[x->at] == '\r' && text[x->at + 1] == '\n';
            *word++ = ' ';
        } else {
            *word++ = text[x->at];
        }
        x->at += length;
    }
    ++x->at;
    *word++ = '\0';
    return word;
}

static int has_attribute(const xml_reader *x, const char *name) {
    for (size_t i = 0; i + 1 < x->attribute_count; i += 2)
        if (strcmp(x->attributes[i], name) == 0) return 1;
    return 0;
}

/* A name and its attributes, up to end; x->at comes to what is behind them. */
static xml_event read_tag(xml_reader *x, size_t end) {
    char *words = norma_io_grow(x->words, &x->word_capacity, end - x->at + 2, 1);
    if (!words) return XML_NO_MEMORY;
    x->words = words;
    x->name = words;
    x->attribute_count = 0;
    char *word = take_xml_name(x, words);
    if (!word) return fail_xml(x, "a name is expected behind <");
    for (;;) {
        const char **list = norma_io_grow(
            x->attributes, &x->attribute_capacity, x->attribute_count + 3, sizeof *list);
        if (!list) return XML_NO_MEMORY;
        x->attributes = list;
        list[x->attribute_count] = NULL;
        const size_t next = skip_xml_blanks(x, x->at);
        if (!begins_name(x->text[next])) {
            x->at = next;
            return XML_BEGINS;
        }
        if (next == x->at) return fail_xml(x, "a space is expected before an attribute");
        if (x->attribute_count == 2 * XML_MOST_ATTRIBUTES)
            return fail_xml(x, "more attributes in a tag than 256");
        x->at = next;
        char *value = take_xml_name(x, word);
        if (has_attribute(x, word)) return fail_xml(x, "an attribute stands twice in a tag");
        x->at = skip_xml_blanks(x, x->at);
        const int has_value = x->text[x->at] == '=';
        x->at = skip_xml_blanks(x, x->at + (size_t)has_value);
        char *after = has_value ? take_xml_value(x, value) : NULL;
        if (!after) return fail_xml(x, "an attribute without a sound value in quotes");
        list[x->attribute_count++] = word;
        list[x->attribute_count++] = value;
        word = after;
    }
}

static xml_event begin_tag(xml_reader *x) {
    const size_t end = tag_end(x), name = ++x->at;
    if (x->depth == 0 && x->has_root) return fail_xml(x, "more than one root element");
    if (end == x->size) return fail_xml(x, "a tag without its end");
    const xml_event event = read_tag(x, end);
    if (event != XML_BEGINS) return event;
    x->is_empty_tag = x->text[x->at] == '/';
    x->at += (size_t)x->is_empty_tag;
    if (x->at != end) return fail_xml(x, "a tag has more than a name and attributes");
    ++x->at;
    xml_span *open = norma_io_add(&x->open, &x->open_capacity, &x->depth, sizeof *open);
    if (!open) return XML_NO_MEMORY;
    *open = (xml_span){name, strlen(x->name)};
    x->has_root = 1;
    return XML_BEGINS;
}

static xml_event end_tag(xml_reader *x) {
    x->at += 2;
    if (!x->depth) return fail_xml(x, "an end without its beginning");
    const xml_span open = x->open[--x->depth];
    if (strncmp(x->text + x->at, x->text + open.at, open.length) != 0 ||
        is_name_byte(x->text[x->at + open.length]))
        return fail_xml(x, "an element ends by another's name");
    x->at = skip_xml_blanks(x, x->at + open.length);
    if (x->text[x->at++] != '>') return fail_xml(x, "a tag without its end");
    return XML_ENDS;
}

/* ---- what is not tags */

/* Skips what goes on to mark, and that; 0: it does not come. */
static int skip_behind(xml_reader *x, size_t from, const char *mark) {
    const char *found = from <= x->size ? strstr(x->text + from, mark) : NULL;
    if (found) x->at = (size_t)(found - x->text) + strlen(mark);
    return found != NULL;
}

/* The next attribute's value if it has that name. */
static const char *take_declared(const xml_reader *x, size_t *next, const char *name) {
    if (*next == x->attribute_count || strcmp(x->attributes[*next], name) != 0) return NULL;
    *next += 2;
    return x->attributes[*next - 1];
}

static xml_event read_declaration(xml_reader *x) {
    x->at += 2;
    const xml_event event = read_tag(x, tag_end(x));
    if (event != XML_BEGINS) return event;
    size_t next = 0;
    const char *version = take_declared(x, &next, "version");
    const char *encoding = take_declared(x, &next, "encoding");
    const char *alone = take_declared(x, &next, "standalone");
    if (!version || strncmp(version, "1.", 2) != 0 || !version[2] ||
        version[2 + strspn(version + 2, "0123456789")] ||
        (alone && strcmp(alone, "yes") != 0 && strcmp(alone, "no") != 0) ||
        next != x->attribute_count || strncmp(x->text + x->at, "?>", 2) != 0)
        return fail_xml(x, "its declaration is not like <?xml version=\"1.0\"?>");
    if (encoding && strcmp(encoding, "UTF-8") != 0 && strcmp(encoding, "utf-8") != 0)
        return refuse_encoding(x, encoding);
    x->at += 2;
    return XML_BEGINS;
}

/* A target of the letters xml is reserved. */
static int skip_instruction(xml_reader *x) {
    const char *target = x->text + x->at + 2;
    size_t length = 0;
    while (is_name_byte(target[length])) ++length;
    const int is_reserved = length == 3 && (target[0] | 0x20) == 'x' && (target[1] | 0x20) == 'm' &&
                            (target[2] | 0x20) == 'l';
    x->at += 2 + length;
    return begins_name(*target) && !is_reserved &&
           (is_xml_blank(target[length]) || strncmp(target + length, "?>", 2) == 0) &&
           skip_behind(x, x->at, "?>");
}

static int skip_comment(xml_reader *x) { /* -- ends it, and nothing else may stand behind that */
    return skip_behind(x, x->at + 4, "--") && x->text[x->at++] == '>';
}

/* Up to the next <. Outside the root element blanks only; ]]> nowhere. */
static int skip_characters(xml_reader *x) {
    const char *text = x->text;
    for (; x->at < x->size && text[x->at] != '<'; ++x->at) {
        const char c = text[x->at];
        if (!x->depth && !is_xml_blank(c)) return 0;
        if (c == ']' && strncmp(text + x->at, "]]>", 3) == 0) return 0;
        if (c == '&') {
            uint32_t code;
            const size_t length = read_reference(text + x->at, &code);
            if (!length) return 0;
            x->at += length - 1;
        }
    }
    return 1;
}

/* The whole text once: no byte outside of its characters needs to be looked for afterwards. */
static int check_characters(xml_reader *x) {
    for (size_t length; x->at < x->size; x->at += length) {
        uint32_t code = (unsigned char)x->text[x->at];
        length = code < 0x80 ? 1 : norma_utf8_take(x->text + x->at, x->size - x->at, &code);
        if (!length || !is_xml_character(code)) {
            x->begin = x->at;
            return 0;
        }
    }
    x->at = 0;
    return 1;
}

static xml_event begin_text(xml_reader *x) {
    x->started = 1;
    if (x->size > 1 && memchr(x->text, '\0', x->size < 64 ? x->size : 64))
        return refuse_encoding(x, "zero bytes, as UTF-16 has them");
    if (!check_characters(x)) return fail_xml(x, "a byte that is in no character of XML in UTF-8");
    if (strncmp(x->text, "\xEF\xBB\xBF", 3) == 0) x->at = 3;
    return strncmp(x->text + x->at, "<?xml", 5) == 0 && is_xml_blank(x->text[x->at + 5])
               ? read_declaration(x)
               : XML_BEGINS;
}

xml_event norma_xml_next(xml_reader *x) {
    if (x->is_empty_tag) {
        x->is_empty_tag = 0;
        --x->depth;
        return XML_ENDS;
    }
    const xml_event began = x->started ? XML_BEGINS : begin_text(x);
    if (began != XML_BEGINS) return began;
    for (;;) {
        x->begin = x->at;
        if (!skip_characters(x))
            return fail_xml(x, x->depth ? "text with an & or ]]> that stands for nothing"
                                        : "text outside the root element");
        x->begin = x->at;
        const char *text = x->text + x->at;
        if (x->at == x->size) break;
        if (text[1] == '/') return end_tag(x);
        if (text[1] == '?') {
            if (!skip_instruction(x)) return fail_xml(x, "an instruction that is not sound");
        } else if (text[1] != '!') {
            return begin_tag(x);
        } else if (strncmp(text, "<!--", 4) == 0) {
            if (!skip_comment(x)) return fail_xml(x, "a comment that is not sound");
        } else if (x->depth && strncmp(text, "<![CDATA[", 9) == 0) {
            if (!skip_behind(x, x->at + 9, "]]>")) return fail_xml(x, "CDATA without its end");
        } else if (!x->has_root && strncmp(text, "<!DOCTYPE", 9) == 0) {
            snprintf(x->wrong, sizeof x->wrong,
                "a document type is not allowed in a 3MF, and its entities are not read");
            return XML_WRONG;
        } else {
            return fail_xml(x, "<! of no known kind");
        }
    }
    if (x->depth) return fail_xml(x, "an element without its end");
    return x->has_root ? XML_DONE : fail_xml(x, "no element");
}

size_t norma_xml_line(const xml_reader *x) {
    size_t line = 1;
    for (size_t at = 0; at < x->begin; ++at)
        line += x->text[at] == '\n' || (x->text[at] == '\r' && x->text[at + 1] != '\n');
    return line;
}

void norma_xml_free(xml_reader *x) {
    free(x->words);
    free(x->attributes);
    free(x->open);
}
