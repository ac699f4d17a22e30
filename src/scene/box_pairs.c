#include "scene/box_pairs.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "base/memory.h"

enum { LEAF = 4, BITS = 21 /* of a Morton code, per axis */ };

struct extent {
  double low[3], high[3];
};

struct key {
  uint64_t code;
  int box;
};

/* Node k of the implicit tree holds the boxes [first, last); its halves are nodes 2k+1 and 2k+2. */
struct range {
  size_t k;
  int first, last;
};

struct tree {
  const struct rad_box *box;
  const struct key *key;
  struct extent *node; /* owned */
  void (*found)(void *, int, int);
  void *context;
};

static void extend(struct extent *x, const double low[3], const double high[3]) {
  for (int m = 0; m < 3; m++) {
    x->low[m] = low[m] < x->low[m] ? low[m] : x->low[m];
    x->high[m] = high[m] > x->high[m] ? high[m] : x->high[m];
  }
}

static struct extent nothing(void) {
  return (struct extent){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}

static int apart(const double low[3], const double high[3], const double other_low[3],
                 const double other_high[3]) {
  return low[0] > other_high[0] || other_low[0] > high[0] || low[1] > other_high[1] ||
         other_low[1] > high[1] || low[2] > other_high[2] || other_low[2] > high[2];
}

/* Bits of the boxes' centres in turn: neighbours in this order are neighbours in space. */
static uint64_t morton(const struct rad_box *b, const struct extent *all) {
  uint64_t code = 0, cell[3];
  for (int m = 0; m < 3; m++) {
    double width = all->high[m] - all->low[m];
    double place = width > 0 ? ((b->low[m] + b->high[m]) / 2 - all->low[m]) / width : 0;
    cell[m] = (uint64_t)(place * ((1 << BITS) - 1));
  }
  for (int bit = BITS - 1; bit >= 0; bit--)
    for (int m = 0; m < 3; m++)
      code = code << 1 | (cell[m] >> bit & 1);
  return code;
}

static int compare_keys(const void *a, const void *b) {
  const struct key *p = a, *q = b;
  if (p->code != q->code)
    return p->code < q->code ? -1 : 1;
  return (p->box > q->box) - (p->box < q->box);
}

static struct range half(struct range r, int second) {
  int middle = r.first + (r.last - r.first) / 2;
  return second ? (struct range){2 * r.k + 2, middle, r.last}
                : (struct range){2 * r.k + 1, r.first, middle};
}

static int is_leaf(struct range r) {
  return r.last - r.first <= LEAF;
}

static const struct rad_box *box_at(const struct tree *t, int place) {
  return &t->box[t->key[place].box];
}

static void measure(struct tree *t, struct range r) {
  struct extent x = nothing();
  if (is_leaf(r)) {
    for (int k = r.first; k < r.last; k++)
      extend(&x, box_at(t, k)->low, box_at(t, k)->high);
  } else {
    for (int second = 0; second < 2; second++) {
      struct range h = half(r, second);
      measure(t, h);
      extend(&x, t->node[h.k].low, t->node[h.k].high);
    }
  }
  t->node[r.k] = x;
}

static void join_leaves(const struct tree *t, struct range r, struct range s) {
  for (int k = r.first; k < r.last; k++)
    for (int o = r.k == s.k ? k + 1 : s.first; o < s.last; o++) {
      const struct rad_box *a = box_at(t, k), *b = box_at(t, o);
      if (!apart(a->low, a->high, b->low, b->high))
        t->found(t->context, a->item, b->item);
    }
}

static void join(const struct tree *t, struct range r, struct range s) {
  const struct extent *a = &t->node[r.k], *b = &t->node[s.k];
  if (apart(a->low, a->high, b->low, b->high))
    return;
  if (is_leaf(r) && is_leaf(s)) {
    join_leaves(t, r, s);
  } else if (r.k == s.k) {
    join(t, half(r, 0), half(r, 0));
    join(t, half(r, 1), half(r, 1));
    join(t, half(r, 0), half(r, 1));
  } else {
    int split_first = !is_leaf(r) && (is_leaf(s) || r.last - r.first >= s.last - s.first);
    for (int second = 0; second < 2; second++)
      join(t, split_first ? half(r, second) : r, split_first ? s : half(s, second));
  }
}

enum rad_code rad_box_pairs(int n, const struct rad_box *box, void (*found)(void *, int, int),
                            void *context, struct rad_error *e) {
  size_t n_node = 1;
  for (int size = n; size > LEAF; size = (size + 1) / 2)
    n_node = 2 * n_node + 1;
  struct key *key = rad_alloc((size_t)n, sizeof *key);
  struct tree t = {box, key, rad_alloc(n_node, sizeof *t.node), found, context};
  enum rad_code code = RAD_OK;
  if (!key || !t.node) {
    code = rad_fail_memory(e, "the search for touching triangles", 60.0 * n);
  } else {
    struct extent all = nothing();
    for (int k = 0; k < n; k++)
      extend(&all, box[k].low, box[k].high);
    for (int k = 0; k < n; k++)
      key[k] = (struct key){morton(&box[k], &all), k};
    qsort(key, (size_t)n, sizeof *key, compare_keys);
    struct range root = {0, 0, n};
    measure(&t, root);
    join(&t, root, root);
  }
  free(key);
  free(t.node);
  return code;
}
