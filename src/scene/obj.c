#include "scene/obj.h"

#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "base/number.h"
#include "base/text.h"
#include "scene/obj_line.h"
#include "scene/polygon.h"

#define BENT 1e-6 /* distance from the mean plane over the diameter: worth a warning */

enum { MAX_CORNER = 10000, MAX_FILE = INT_MAX /* bytes; also keeps all counts in an int */ };

/* What can name a surface, by rank. */
enum naming { BY_MATERIAL, BY_GROUP, BY_OBJECT, N_NAMING };

/* Faces in a row with the same names. */
struct part {
  struct rad_word name[N_NAMING]; /* in the text; n = 0: none */
};

struct reader {
  const char *path;
  struct rad_scan scan;
  struct rad_obj *obj;
  struct rad_notes *notes;
  struct rad_error *e;
  size_t room_vertex, room_triangle, room_part, room_corner; /* allocated */
  int n_part;
  struct part *part; /* owned [n_part] */
  struct part now;
  int has_name[N_NAMING];
  struct rad_polygon face; /* owned arrays [room_corner] */
  long n_bent;
};

#define FAIL(r, ...) fail(r, (r)->scan.line, __VA_ARGS__)

static enum rad_code fail(struct reader *r, int line, const char *fmt, ...)
    __attribute__((format(printf, 3, 4)));

static enum rad_code fail(struct reader *r, int line, const char *fmt, ...) {
  char what[512];
  va_list args;
  va_start(args, fmt);
  vsnprintf(what, sizeof what, fmt, args);
  va_end(args);
  rad_make_printable(what);
  return rad_fail(r->e, RAD_EINPUT, "%.400s:%d: error: %s", r->path, line, what);
}

/* printf's arguments for "%.*s" of a word, cut to a readable length */
#define SHOWN(word) (int)((word).n < 40 ? (word).n : 40), (word).text

/* Room for one more item. */
static enum rad_code make_room(struct reader *r, void **array, size_t n, size_t *room,
                               size_t item) {
  return rad_reserve(array, n + 1, room, item)
             ? RAD_OK
             : rad_fail_memory(r->e, "the mesh", 2 * (double)*room * (double)item);
}

/* --- vertices --- */

static enum rad_code read_vertex(struct reader *r) {
  double value[7];
  int n = 0;
  for (struct rad_word word; rad_scan_word(&r->scan, &word); n++) {
    if (n == 7)
      return FAIL(r, "a vertex with more than 7 numbers; give x y z after 'v'");
    if (!rad_number_parse(word.text, word.n, &value[n]))
      return FAIL(r, "'%.*s' is no finite number; give x y z as decimal numbers after 'v'",
                  SHOWN(word));
  }
  if (n != 3 && n != 4 && n != 6 && n != 7) /* x y z, weight, colour */
    return FAIL(r, "a vertex with %d number%s; give x y z after 'v'", n, n == 1 ? "" : "s");
  if (n % 3 == 1 && value[3] != 1)
    return FAIL(r, "a vertex of weight %g, but only polygons are read; leave the weight out",
                value[3]);
  struct rad_obj *obj = r->obj;
  void *array = obj->vertex;
  enum rad_code code =
      make_room(r, &array, (size_t)obj->n_vertex, &r->room_vertex, sizeof *obj->vertex);
  obj->vertex = array;
  if (!code)
    memcpy(obj->vertex[obj->n_vertex++], value, sizeof *obj->vertex);
  return code;
}

/* --- names --- */

static enum rad_code read_name(struct reader *r, enum naming kind, const char *statement) {
  struct rad_word name = rad_scan_rest(&r->scan);
  for (size_t k = 0; k < name.n;) {
    unsigned code;
    int length = rad_utf8_decode(name.text + k, name.n - k, &code);
    if (length == 0 || code < 0x20 || code == 0x7F)
      return FAIL(r, "byte 0x%02X in the name after '%s'; give names in UTF-8, on one line",
                  (unsigned char)name.text[k], statement);
    k += (size_t)length;
  }
  if (name.n == 0 && kind == BY_MATERIAL)
    return FAIL(r, "'usemtl' without a name; write usemtl NAME");
  r->now.name[kind] = name;
  r->has_name[kind] = 1;
  return RAD_OK;
}

static int same_word(struct rad_word a, struct rad_word b) {
  return a.n == b.n && (a.n == 0 || !memcmp(a.text, b.text, a.n));
}

/* Start a new part if the names have changed since the last face. */
static enum rad_code open_part(struct reader *r) {
  int same = r->n_part > 0;
  for (int k = 0; same && k < N_NAMING; k++)
    same = same_word(r->part[r->n_part - 1].name[k], r->now.name[k]);
  if (same)
    return RAD_OK;
  void *array = r->part;
  enum rad_code code = make_room(r, &array, (size_t)r->n_part, &r->room_part, sizeof *r->part);
  r->part = array;
  if (!code)
    r->part[r->n_part++] = r->now;
  return code;
}

/* The file's name without folder and extension. */
static struct rad_word base_name(const char *path) {
  const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path;
  const char *dot = strrchr(base, '.');
  return (struct rad_word){base, dot && dot > base ? (size_t)(dot - base) : strlen(base)};
}

static enum rad_code name_parts(struct reader *r) {
  struct rad_obj *obj = r->obj;
  int kind = BY_MATERIAL;
  while (kind < BY_OBJECT && !r->has_name[kind])
    kind++;
  int n = r->n_part;
  obj->part_name = rad_calloc((size_t)n, sizeof *obj->part_name);
  for (int k = 0; obj->part_name && k < n; k++) {
    struct rad_word name = r->part[k].name[kind];
    name = name.n ? name : base_name(r->path);
    if (!(obj->part_name[k] = strndup(name.text, name.n)))
      break;
    obj->n_part++;
  }
  return obj->n_part == n ? RAD_OK : rad_fail_memory(r->e, "the mesh", 32.0 * n);
}

/* --- faces --- */

/* A whole number at *s, saturated; 0 if there is none. */
static int read_index(const char **s, const char *end, long *index) {
  int negative = *s < end && **s == '-';
  *s += negative;
  const char *first = *s;
  *index = 0;
  for (; *s < end && **s >= '0' && **s <= '9'; ++*s)
    *index = *index < INT_MAX ? 10 * *index + (**s - '0') : INT_MAX;
  *index = negative ? -*index : *index;
  return *s > first;
}

/* v, v/vt, v//vn or v/vt/vn; only v matters. */
static int read_corner(struct rad_word word, long *index) {
  const char *s = word.text, *end = s + word.n;
  long unused;
  if (!read_index(&s, end, index))
    return 0;
  if (s == end)
    return 1;
  if (*s++ != '/')
    return 0;
  if (read_index(&s, end, &unused) && s == end)
    return 1;
  return s < end && *s++ == '/' && read_index(&s, end, &unused) && s == end;
}

static enum rad_code grow_face(struct reader *r) {
  struct rad_polygon *p = &r->face;
  size_t n = (size_t)p->n, room = r->room_corner;
  void *array[4] = {p->x, p->vertex, p->corner, p->triangle};
  const size_t item[4] = {sizeof *p->x, sizeof *p->vertex, sizeof *p->corner, sizeof *p->triangle};
  enum rad_code code = RAD_OK;
  for (int k = 0; k < 4 && !code; k++) {
    room = r->room_corner;
    code = make_room(r, &array[k], n, &room, item[k]);
  }
  p->x = array[0];
  p->vertex = array[1];
  p->corner = array[2];
  p->triangle = array[3];
  r->room_corner = code ? r->room_corner : room;
  return code;
}

static enum rad_code add_corner(struct reader *r, struct rad_word word) {
  struct rad_polygon *p = &r->face;
  const struct rad_obj *obj = r->obj;
  long index;
  if (!read_corner(word, &index))
    return FAIL(r, "'%.*s' is no corner of a face; write vertex numbers as 1, 1/2, 1//3 or 1/2/3",
                SHOWN(word));
  if (index == 0)
    return FAIL(r, "there is no vertex 0; count from 1, or from -1 for the last one above");
  if (labs(index) > obj->n_vertex)
    return FAIL(r, "there is no vertex %.*s, only %d above this line; correct the number",
                (int)strcspn(word.text, "/ \t\r\n"), word.text, obj->n_vertex);
  if (p->n == MAX_CORNER)
    return FAIL(r, "a face of more than %d corners; divide it", MAX_CORNER);
  enum rad_code code = grow_face(r);
  if (code)
    return code;
  int vertex = (int)(index > 0 ? index - 1 : obj->n_vertex + index);
  for (int k = 0; k < p->n; k++)
    if (p->vertex[k] == vertex)
      return FAIL(r, "corners %d and %d of the face are both vertex %d; remove one of them", k + 1,
                  p->n + 1, vertex + 1);
  memcpy(p->x[p->n], obj->vertex[vertex], sizeof *p->x);
  p->vertex[p->n++] = vertex;
  return RAD_OK;
}

static void note_bend(struct reader *r) {
  if (!(r->face.bend > BENT))
    return;
  if (++r->n_bent <= RAD_MAX_BENT_NOTES)
    rad_notes_add(r->notes,
                  "%.400s:%d: warning: the face is not plane (%.2g of its diameter); its triangles "
                  "are used, divide it to choose them",
                  r->path, r->scan.line, r->face.bend);
}

static enum rad_code add_triangles(struct reader *r) {
  struct rad_obj *obj = r->obj;
  const struct rad_polygon *p = &r->face;
  enum rad_code code = open_part(r);
  for (int k = 0; k < p->n - 2 && !code; k++) {
    void *array = obj->triangle;
    code = make_room(r, &array, (size_t)obj->n_triangle, &r->room_triangle, sizeof *obj->triangle);
    obj->triangle = array;
    if (!code) {
      const int *corner = p->triangle[k];
      obj->triangle[obj->n_triangle++] = (struct rad_obj_triangle){
          {p->vertex[corner[0]], p->vertex[corner[1]], p->vertex[corner[2]]},
          r->n_part - 1,
          r->scan.line};
    }
  }
  return code;
}

static enum rad_code read_face(struct reader *r) {
  r->face.n = 0;
  for (struct rad_word word; rad_scan_word(&r->scan, &word);) {
    enum rad_code code = add_corner(r, word);
    if (code)
      return code;
  }
  if (r->face.n < 3)
    return FAIL(r, "a face with %d corner%s; give at least three", r->face.n,
                r->face.n == 1 ? "" : "s");
  enum rad_polygon_fault fault = rad_polygon_triangulate(&r->face);
  if (fault == RAD_POLYGON_LINE)
    return FAIL(r, "a face without area, its corners lie on a line; move one or delete the face");
  if (fault == RAD_POLYGON_CROSSED)
    return FAIL(r, "the outline of the face crosses or touches itself; divide the face");
  note_bend(r);
  return add_triangles(r);
}

/* --- statements --- */

static int is_one_of(struct rad_word word, const char *const *list) {
  for (; *list; list++)
    if (strlen(*list) == word.n && !memcmp(*list, word.text, word.n))
      return 1;
  return 0;
}

static enum rad_code read_statement(struct reader *r) {
  static const char *const passed_over[] = {
      "vt",       "vn",  "vp",     "s",      "mtllib",   "l",          "p",         "bevel",
      "c_interp", "lod", "maplib", "usemap", "d_interp", "shadow_obj", "trace_obj", NULL};
  static const char *const free_form[] = {"cstype", "deg",  "bmat",  "step",  "curv", "curv2",
                                          "surf",   "parm", "trim",  "hole",  "scrv", "sp",
                                          "end",    "con",  "ctech", "stech", NULL};
  struct rad_word word;
  if (!rad_scan_word(&r->scan, &word))
    return RAD_OK;
  if (word.n == 1 && *word.text == 'v')
    return read_vertex(r);
  if (word.n == 1 && *word.text == 'f')
    return read_face(r);
  if (word.n == 1 && *word.text == 'g')
    return read_name(r, BY_GROUP, "g");
  if (word.n == 1 && *word.text == 'o')
    return read_name(r, BY_OBJECT, "o");
  if (word.n == 6 && !memcmp(word.text, "usemtl", 6))
    return read_name(r, BY_MATERIAL, "usemtl");
  if (is_one_of(word, passed_over))
    return RAD_OK;
  if (is_one_of(word, free_form))
    return FAIL(r, "'%.*s' belongs to a free-form surface; export polygons", SHOWN(word));
  return FAIL(r, "unknown statement '%.*s'; this is to be a Wavefront OBJ file: v, f, g, o, usemtl",
              SHOWN(word));
}

static enum rad_code read_text(struct reader *r, const char *text, size_t n) {
  size_t n_text = strlen(text), mark = n >= 3 && !memcmp(text, "\xEF\xBB\xBF", 3) ? 3 : 0;
  r->scan = (struct rad_scan){text + mark, 1, 1};
  enum rad_code code = RAD_OK;
  do
    code = read_statement(r);
  while (!code && rad_scan_next(&r->scan));
  if (!code && n_text < n)
    code = FAIL(r, "a zero byte, so this is no text; export the scene as a Wavefront OBJ file");
  if (code)
    return code;
  if (n_text == strspn(text, " \t\r\n"))
    return rad_fail(r->e, RAD_EINPUT, "%.400s: error: the file is empty; export the scene again",
                    r->path);
  if (r->obj->n_triangle == 0)
    return rad_fail(r->e, RAD_EINPUT,
                    "%.400s: error: there are no faces in the file; export polygons ('f' lines)",
                    r->path);
  return name_parts(r);
}

enum rad_code rad_obj_read(const char *path, struct rad_obj *obj, struct rad_notes *notes,
                           struct rad_error *e) {
  *obj = (struct rad_obj){0};
  struct reader r = {.path = path, .obj = obj, .notes = notes, .e = e};
  char *text;
  size_t n;
  enum rad_code code =
      rad_file_read(path, "the mesh (scene.mesh.file)", MAX_FILE, "divide the scene", &text, &n, e);
  if (!code)
    code = read_text(&r, text, n);
  if (!code && r.n_bent > RAD_MAX_BENT_NOTES)
    rad_notes_add(notes, "%.400s: warning: and %ld more faces that are not plane", path,
                  r.n_bent - RAD_MAX_BENT_NOTES);
  free(text);
  free(r.part);
  free(r.face.x);
  free(r.face.vertex);
  free(r.face.corner);
  free(r.face.triangle);
  return code;
}

void rad_obj_free(struct rad_obj *obj) {
  for (int k = 0; k < obj->n_part; k++)
    free(obj->part_name[k]);
  free(obj->part_name);
  free(obj->vertex);
  free(obj->triangle);
  *obj = (struct rad_obj){0};
}
