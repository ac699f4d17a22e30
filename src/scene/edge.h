/* Edges by their two vertices, to find those that polygons have in common. */
#ifndef RAD_SCENE_EDGE_H
#define RAD_SCENE_EDGE_H

/* One polygon's edge; number: the caller's. */
struct rad_edge {
  int low, high, number;
};

static inline struct rad_edge rad_edge_of(int p, int q, int number) {
  return (struct rad_edge){p < q ? p : q, p < q ? q : p, number};
}

/* By vertices, then by number: those of the same two vertices stand side by side. */
void rad_edges_sort(int n, struct rad_edge *edge);

/* The first edge from `first` on that has other vertices; n if there is none. */
int rad_edges_end(int n, const struct rad_edge *edge, int first);

#endif
