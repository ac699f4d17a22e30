/* What is said of triangles that meet other than in a vertex or a whole edge. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "scene/check.h"
#include "scene/contact.h"

/* The first pairs of a kind in deck order, of all those that were found. */
struct pairs {
  long n;
  int first[RAD_MAX_CONTACT_NOTES][2];
};

struct meeting {
  const struct rad_checked *c;
  struct pairs touching, crossing, overlapping;
  unsigned char *two_sided; /* owned [n_surface] a flux is given on faces back to back */
};

static void add_pair(struct pairs *p, int low, int high) {
  int at = p->n < RAD_MAX_CONTACT_NOTES ? (int)p->n : RAD_MAX_CONTACT_NOTES;
  p->n++;
  while (at > 0 && (p->first[at - 1][0] > low ||
                    (p->first[at - 1][0] == low && p->first[at - 1][1] > high))) {
    at--;
    if (at + 1 < RAD_MAX_CONTACT_NOTES)
      memcpy(p->first[at + 1], p->first[at], sizeof p->first[at]);
  }
  if (at < RAD_MAX_CONTACT_NOTES) {
    p->first[at][0] = low;
    p->first[at][1] = high;
  }
}

/* Two sides of one surface, each with its own temperature. */
static void add_back_to_back(struct meeting *m, int a, int b) {
  const struct rad_scene *s = m->c->scene;
  if (s->heat && s->heat[a].kind == RAD_HEAT_FLUX && s->heat[b].kind == RAD_HEAT_FLUX &&
      s->triangle[a].surface == s->triangle[b].surface)
    m->two_sided[s->triangle[a].surface] = 1;
}

static void take(void *context, int low, int high, enum rad_contact kind) {
  struct meeting *m = context;
  if (kind == RAD_BACK_TO_BACK)
    add_back_to_back(m, low, high);
  else
    add_pair(kind == RAD_TOUCHING   ? &m->touching
             : kind == RAD_CROSSING ? &m->crossing
                                    : &m->overlapping,
             low, high);
}

/* "triangle 3 (floor)", with its line if `from` is a triangle whose message does not tell it. */
static void describe(const struct rad_checked *c, int t, int from, char *text, size_t size) {
  const struct rad_triangle *tri = &c->scene->triangle[t];
  const char *path = rad_checked_path(c, t);
  char place[300] = "";
  if (from >= 0 && tri->line > 0 && path == rad_checked_path(c, from))
    snprintf(place, sizeof place, ", line %d", tri->line);
  else if (from >= 0 && tri->line > 0)
    snprintf(place, sizeof place, ", %s:%d", path, tri->line);
  snprintf(text, size, "triangle %d (%s%s)", c->number[t], c->scene->surface_name[tri->surface],
           place);
}

static enum rad_code refuse_overlap(const struct meeting *m, struct rad_error *e) {
  const struct pairs *p = &m->overlapping;
  char other[512], more[64] = "";
  if (p->n == 0)
    return RAD_OK;
  describe(m->c, p->first[0][0], p->first[0][1], other, sizeof other);
  if (p->n > 1)
    snprintf(more, sizeof more, "; %ld more pair%s of triangles overlap%s", p->n - 1,
             p->n > 2 ? "s" : "", p->n > 2 ? "" : "s");
  return rad_check_fail(m->c, p->first[0][1], e,
                        "overlaps %s, in the same plane and facing the same way, so that the "
                        "common area would count twice; delete one, turn one over (side: back), "
                        "or cut the common part out of one (tools/convert --conform keeps the "
                        "smaller)%s",
                        other, more);
}

/* Name at most `most` pairs; their number. */
static long note_pairs(const struct rad_checked *c, const struct pairs *p, long most,
                       const char *verb, const char *advice, struct rad_notes *notes) {
  long n = p->n < most ? p->n : most;
  for (long k = 0; k < n; k++) {
    int a = p->first[k][0], b = p->first[k][1];
    char line[16] = "", first[512], second[512];
    if (c->scene->triangle[b].line > 0)
      snprintf(line, sizeof line, ":%d", c->scene->triangle[b].line);
    describe(c, b, -1, second, sizeof second);
    describe(c, a, -1, first, sizeof first);
    rad_notes_add(notes, "%s%s: warning: %s %s %s%s", rad_checked_path(c, b), line, second, verb,
                  first, advice);
  }
  return n;
}

static void note_meeting(const struct meeting *m, struct rad_notes *notes) {
  const struct rad_checked *c = m->c;
  long left = RAD_MAX_CONTACT_NOTES;
  left -= note_pairs(c, &m->crossing, left, "crosses",
                     ", where the radiosity jumps inside both; cut them along their common line "
                     "(tools/convert --conform)",
                     notes);
  long n_crossing = m->crossing.n - (RAD_MAX_CONTACT_NOTES - left);
  if (n_crossing > 0)
    rad_notes_add(notes, "%s: warning: and %ld more pair%s of triangles cross%s", c->path,
                  n_crossing, n_crossing > 1 ? "s" : "", n_crossing > 1 ? "" : "es");
  long n_touching =
      m->touching.n - note_pairs(c, &m->touching, left, "touches",
                                 " other than in a vertex or a whole edge; divide them so that "
                                 "they share vertices and edges",
                                 notes);
  if (n_touching > 0)
    rad_notes_add(notes,
                  "%s: warning: and %ld more pair%s of triangles touch%s other than in a vertex or "
                  "a whole edge",
                  c->path, n_touching, n_touching > 1 ? "s" : "", n_touching > 1 ? "" : "es");
}

static void note_two_sided(const struct meeting *m, struct rad_notes *notes) {
  const struct rad_scene *s = m->c->scene;
  int n = 0;
  for (int i = 0; i < s->n_surface; i++)
    if (m->two_sided[i] && n++ < RAD_MAX_CONTACT_NOTES)
      rad_notes_add(notes,
                    "%s: warning: surface '%s' has a flux and two sides: each side gives off that "
                    "flux and has a temperature of its own, as if insulated from the other; for "
                    "a sheet of one temperature make the sides two surfaces, with fluxes q and -q, "
                    "and choose q so that their temperatures agree",
                    m->c->path, s->surface_name[i]);
  if (n > RAD_MAX_CONTACT_NOTES)
    rad_notes_add(notes, "%s: warning: and %d more surfaces have a flux on both sides of a sheet",
                  m->c->path, n - RAD_MAX_CONTACT_NOTES);
}

enum rad_code rad_check_contacts(const struct rad_checked *c, struct rad_notes *notes,
                                 struct rad_error *e) {
  const struct rad_scene *s = c->scene;
  struct meeting m = {.c = c, .two_sided = rad_calloc((size_t)s->n_surface, 1)};
  if (!m.two_sided)
    return rad_fail_memory(e, "the search for touching triangles", s->n_surface);
  enum rad_code code = rad_find_contacts(s, c->number, take, &m, e);
  for (int t = 0; t + 1 < s->n_triangle; t++)
    if (c->number[t] == c->number[t + 1])
      add_back_to_back(&m, t, t + 1);
  if (!code)
    code = refuse_overlap(&m, e);
  if (!code) {
    note_meeting(&m, notes);
    note_two_sided(&m, notes);
  }
  free(m.two_sided);
  return code;
}
