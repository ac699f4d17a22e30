#include "scene/yaml.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <yaml.h>

#include "base/text.h"

struct rad_yaml_chunk {
  struct rad_yaml_chunk *next;
  size_t used, size;
  _Alignas(max_align_t) char bytes[];
};

enum { CHUNK_BYTES = 1 << 18 };

struct parse {
  struct rad_yaml *y;
  unsigned short source;
  const char *text; /* [n] */
  size_t n;
  yaml_parser_t parser;
};

static enum rad_code read_node(struct parse *p, const yaml_event_t *event, int depth,
                               struct rad_yaml_node **out);

static void *take(struct rad_yaml *y, size_t bytes, size_t align) {
  struct rad_yaml_chunk *c = y->chunk;
  size_t start = c ? (c->used + align - 1) / align * align : 0;
  if (!c || start > c->size || c->size - start < bytes) {
    size_t size = bytes > CHUNK_BYTES ? bytes : CHUNK_BYTES;
    c = malloc(sizeof *c + size);
    if (!c) {
      rad_fail_memory(y->e, "the deck", (double)size);
      return NULL;
    }
    *c = (struct rad_yaml_chunk){.next = y->chunk, .size = size};
    y->chunk = c;
    start = 0;
  }
  c->used = start + bytes;
  return c->bytes + start;
}

void rad_yaml_free(struct rad_yaml *y) {
  while (y->chunk) {
    struct rad_yaml_chunk *next = y->chunk->next;
    free(y->chunk);
    y->chunk = next;
  }
}

struct rad_yaml_node *rad_yaml_node_new(struct rad_yaml *y, const struct rad_yaml_node *at,
                                        enum rad_yaml_kind kind, const char *text, size_t n) {
  struct rad_yaml_node *node = take(y, sizeof *node, _Alignof(struct rad_yaml_node));
  if (!node)
    return NULL;
  *node = *at;
  node->next = NULL;
  node->first = NULL;
  node->kind = (unsigned char)kind;
  node->n = (int)n;
  if (kind == RAD_YAML_SCALAR) {
    char *copy = take(y, n + 1, 1);
    if (!copy)
      return NULL;
    memcpy(copy, text, n);
    copy[n] = '\0';
    node->text = copy;
  }
  return node;
}

bool rad_yaml_is_nothing(const struct rad_yaml_node *node) {
  if (node->kind != RAD_YAML_SCALAR || !node->plain)
    return false;
  const char *s = node->text;
  return !*s || !strcmp(s, "~") || !strcmp(s, "null") || !strcmp(s, "Null") || !strcmp(s, "NULL");
}

enum rad_code rad_yaml_fail(struct rad_yaml *y, const struct rad_yaml_node *at, const char *fmt,
                            ...) {
  char what[640], note[sizeof y->blame_note] = "", where[32] = "";
  va_list args;
  va_start(args, fmt);
  vsnprintf(what, sizeof what, fmt, args);
  va_end(args);
  if (y->blame && !at->study) {
    memcpy(note, y->blame_note, sizeof note);
    if (at->source == 0)
      snprintf(where, sizeof where, " (line %d)", at->line);
    at = y->blame;
  }
  rad_make_printable(what);
  rad_make_printable(note);
  if (at->source == 0)
    return rad_fail(y->e, RAD_EINPUT, "%.400s:%d:%d: error: %s%s%s", y->path, at->line, at->column,
                    note, what, where);
  char set[200];
  snprintf(set, sizeof set, "%s", y->set[at->source - 1]);
  rad_make_printable(set);
  return rad_fail(y->e, RAD_EINPUT, "--set %s: error: %s%s%s", set, note, what, where);
}

static struct rad_yaml_node place(const struct parse *p, yaml_mark_t mark) {
  return (struct rad_yaml_node){
      .line = (int)mark.line + 1, .column = (int)mark.column + 1, .source = p->source};
}

/* The characters that YAML allows, so that libyaml's reader has nothing left to refuse. */
static bool is_allowed(unsigned c) {
  return c == '\t' || c == '\n' || c == '\r' || (c >= 0x20 && c < 0x7F) || c == 0x85 ||
         (c >= 0xA0 && c <= 0xFFFD) || c >= 0x10000;
}

static enum rad_code check_characters(struct parse *p) {
  struct rad_yaml_node at = {.line = 1, .column = 1, .source = p->source};
  bool indentation = true;
  for (size_t i = 0; i < p->n;) {
    unsigned c;
    int length = rad_utf8_decode(p->text + i, p->n - i, &c);
    if (length == 0)
      return rad_yaml_fail(p->y, &at, "byte 0x%02X is not UTF-8; save the file as UTF-8 text",
                           (unsigned char)p->text[i]);
    if (!is_allowed(c))
      return rad_yaml_fail(p->y, &at, "control character 0x%02X; remove it", c);
    if (c == '\t' && indentation)
      return rad_yaml_fail(p->y, &at, "a tab in the indentation; use spaces");
    i += (size_t)length;
    at.column++;
    indentation = indentation && c == ' ';
    if (c == '\n' || (c == '\r' && (i == p->n || p->text[i] != '\n'))) {
      at.line++;
      at.column = 1;
      indentation = true;
    }
  }
  return RAD_OK;
}

static bool tab_at(const struct parse *p, yaml_mark_t mark) {
  const char *s = p->text, *end = s + p->n;
  for (size_t line = 0; line < mark.line && s; line++) {
    s = memchr(s, '\n', (size_t)(end - s));
    s = s ? s + 1 : NULL;
  }
  for (size_t column = 0; s && s < end && *s != '\n'; column++) {
    if (column == mark.column)
      return *s == '\t';
    unsigned c;
    s += rad_utf8_decode(s, (size_t)(end - s), &c);
  }
  return false;
}

static enum rad_code syntax_error(struct parse *p) {
  const yaml_parser_t *parser = &p->parser;
  if (parser->error == YAML_MEMORY_ERROR)
    return rad_fail_memory(p->y->e, "the deck", (double)p->n);
  struct rad_yaml_node at = place(p, parser->problem_mark);
  if (parser->error == YAML_SCANNER_ERROR && tab_at(p, parser->problem_mark))
    return rad_yaml_fail(p->y, &at, "a tab in the indentation; use spaces");
  const char *problem = parser->problem ? parser->problem : "unreadable text";
  if (!parser->context)
    return rad_yaml_fail(p->y, &at,
                         "not valid YAML, %s; check the indentation, brackets and quotes", problem);
  return rad_yaml_fail(
      p->y, &at,
      "not valid YAML, %s %s from line %d on; check the indentation, brackets and quotes", problem,
      parser->context, (int)parser->context_mark.line + 1);
}

static enum rad_code next_event(struct parse *p, yaml_event_t *event) {
  return yaml_parser_parse(&p->parser, event) ? RAD_OK : syntax_error(p);
}

static int by_text_then_place(const void *a, const void *b) {
  const struct rad_yaml_node *k = *(const struct rad_yaml_node *const *)a;
  const struct rad_yaml_node *l = *(const struct rad_yaml_node *const *)b;
  int order = strcmp(k->text, l->text);
  if (order)
    return order;
  return k->line != l->line ? (k->line > l->line) - (k->line < l->line)
                            : (k->column > l->column) - (k->column < l->column);
}

/* Sorted when there are many, since surfaces may be thousands. */
static enum rad_code check_duplicates(struct rad_yaml *y, const struct rad_yaml_node *map,
                                      size_t n) {
  const struct rad_yaml_node *few[16], **key = few;
  if (n > sizeof few / sizeof *few && !(key = malloc(n * sizeof *key)))
    return rad_fail_memory(y->e, "the deck", (double)(n * sizeof *key));
  n = 0;
  for (const struct rad_yaml_node *k = map->first; k; k = k->next->next)
    key[n++] = k;
  qsort(key, n, sizeof *key, by_text_then_place);
  enum rad_code code = RAD_OK;
  for (size_t i = 1; i < n && !code; i++)
    if (!strcmp(key[i - 1]->text, key[i]->text))
      code = rad_yaml_fail(y, key[i], "duplicate key '%.60s', first given on line %d; remove one",
                           key[i]->text, key[i - 1]->line);
  if (key != few)
    free(key);
  return code;
}

static enum rad_code read_children(struct parse *p, yaml_event_type_t end, int depth,
                                   struct rad_yaml_node *parent) {
  struct rad_yaml_node **tail = &parent->first;
  for (size_t n = 0;; n++) {
    yaml_event_t event;
    enum rad_code code = next_event(p, &event);
    if (code)
      return code;
    if (event.type == end) {
      yaml_event_delete(&event);
      parent->n = parent->kind == RAD_YAML_LIST ? (int)n : 0;
      return parent->kind == RAD_YAML_MAP ? check_duplicates(p->y, parent, n / 2) : RAD_OK;
    }
    code = read_node(p, &event, depth + 1, tail);
    yaml_event_delete(&event);
    if (code)
      return code;
    const struct rad_yaml_node *child = *tail;
    if (parent->kind == RAD_YAML_MAP && n % 2 == 0 &&
        (child->kind != RAD_YAML_SCALAR || child->n == 0))
      return rad_yaml_fail(p->y, child, "a key must be a name; write NAME: VALUE");
    tail = &(*tail)->next;
  }
}

static enum rad_code read_scalar(struct parse *p, const yaml_event_t *event,
                                 struct rad_yaml_node *at, struct rad_yaml_node **out) {
  const char *text = (const char *)event->data.scalar.value;
  size_t n = event->data.scalar.length;
  if (memchr(text, '\0', n))
    return rad_yaml_fail(p->y, at, "a zero byte in a text; remove it");
  at->plain = event->data.scalar.style == YAML_PLAIN_SCALAR_STYLE;
  *out = rad_yaml_node_new(p->y, at, RAD_YAML_SCALAR, text, n);
  return *out ? RAD_OK : RAD_ESYSTEM;
}

static enum rad_code read_node(struct parse *p, const yaml_event_t *event, int depth,
                               struct rad_yaml_node **out) {
  struct rad_yaml_node at = place(p, event->start_mark);
  bool is_scalar = event->type == YAML_SCALAR_EVENT,
       is_map = event->type == YAML_MAPPING_START_EVENT;
  if (event->type == YAML_ALIAS_EVENT)
    return rad_yaml_fail(p->y, &at, "aliases (*%.40s) are not supported; write the value out",
                         (const char *)event->data.alias.anchor);
  if (!is_scalar && !is_map && event->type != YAML_SEQUENCE_START_EVENT)
    return rad_yaml_fail(p->y, &at, "a value was expected here; write one");
  const yaml_char_t *anchor = is_scalar ? event->data.scalar.anchor
                              : is_map  ? event->data.mapping_start.anchor
                                        : event->data.sequence_start.anchor;
  const yaml_char_t *tag = is_scalar ? event->data.scalar.tag
                           : is_map  ? event->data.mapping_start.tag
                                     : event->data.sequence_start.tag;
  if (anchor)
    return rad_yaml_fail(p->y, &at, "anchors (&%.40s) are not supported; remove it",
                         (const char *)anchor);
  if (tag)
    return rad_yaml_fail(p->y, &at, "tags (%.40s) are not supported; remove it", (const char *)tag);
  if (is_scalar)
    return read_scalar(p, event, &at, out);
  if (depth >= RAD_YAML_MAX_DEPTH)
    return rad_yaml_fail(p->y, &at, "nested %d deep; at most %d is allowed", depth,
                         RAD_YAML_MAX_DEPTH - 1);
  *out = rad_yaml_node_new(p->y, &at, is_map ? RAD_YAML_MAP : RAD_YAML_LIST, NULL, 0);
  if (!*out)
    return RAD_ESYSTEM;
  return read_children(p, is_map ? YAML_MAPPING_END_EVENT : YAML_SEQUENCE_END_EVENT, depth, *out);
}

static enum rad_code read_stream(struct parse *p, struct rad_yaml_node **root) {
  for (bool done = false; !done;) {
    yaml_event_t event;
    enum rad_code code = next_event(p, &event);
    if (code)
      return code;
    struct rad_yaml_node at = place(p, event.start_mark);
    done = event.type == YAML_STREAM_END_EVENT;
    if (event.type == YAML_DOCUMENT_START_EVENT && *root)
      code = rad_yaml_fail(p->y, &at, "a second document; put each deck in a file of its own");
    else if (event.type != YAML_STREAM_START_EVENT && event.type != YAML_DOCUMENT_START_EVENT &&
             event.type != YAML_DOCUMENT_END_EVENT && !done)
      code = read_node(p, &event, 1, root);
    yaml_event_delete(&event);
    if (code)
      return code;
  }
  return RAD_OK;
}

enum rad_code rad_yaml_parse(struct rad_yaml *y, unsigned short source, const char *text, size_t n,
                             struct rad_yaml_node **root) {
  *root = NULL;
  size_t mark = n >= 3 && !memcmp(text, "\xEF\xBB\xBF", 3) ? 3 : 0;
  struct parse p = {.y = y, .source = source, .text = text + mark, .n = n - mark};
  enum rad_code code = check_characters(&p);
  if (code)
    return code;
  if (!yaml_parser_initialize(&p.parser))
    return rad_fail_memory(y->e, "the deck", (double)n);
  yaml_parser_set_encoding(&p.parser, YAML_UTF8_ENCODING);
  yaml_parser_set_input_string(&p.parser, (const unsigned char *)p.text, p.n);
  code = read_stream(&p, root);
  yaml_parser_delete(&p.parser);
  if (code || *root)
    return code;
  struct rad_yaml_node at = {.line = 1, .column = 1, .source = source, .plain = true};
  *root = rad_yaml_node_new(y, &at, RAD_YAML_SCALAR, "", 0);
  return *root ? RAD_OK : RAD_ESYSTEM;
}
