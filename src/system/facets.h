/* Assembly for scenes of many facets: one constant trial function on each whole triangle. */
#ifndef RAD_SYSTEM_FACETS_H
#define RAD_SYSTEM_FACETS_H

#include "integrate/element.h"

enum { RAD_FACET_COLUMNS = 8 }; /* of a task */

/* True if every triangle is one plain patch with one element of one constant function. */
int rad_mesh_is_facets(const struct rad_mesh *mesh);

/**
 * K[i + n j] for such a mesh, by Lambert's form (theory 3.9), in parallel over columns; entries
 * that need more digits than it has, and triangles that see each other in part, by rad_patch_block.
 *
 * @param[in]     sees     [n, n] symmetric, enum rad_sight; of hidden pairs the entry is left alone
 * @param[out]    k        [n, n] zeroed
 * @param[in,out] done     [rad_facets_tasks] groups of columns that are done, see rad_task_begin
 * @param[in,out] scratch  [threads]; counts entries by Lambert's form as far
 * Every entry to rules->tolerance of itself. Same bits for any number of threads.
 */
enum rad_code rad_facets_assemble(const struct rad_mesh *mesh, const struct rad_rules *rules,
                                  const unsigned char *sees, double *k, unsigned char *done,
                                  struct rad_scratch *scratch, struct rad_error *e);
int64_t rad_facets_tasks(const struct rad_mesh *mesh);

#endif
