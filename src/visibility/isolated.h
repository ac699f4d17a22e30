/* Faces, shells and scenes that see nothing: doubtful, or without an answer. */
#ifndef RAD_VISIBILITY_ISOLATED_H
#define RAD_VISIBILITY_ISOLATED_H

#include "visibility/visibility.h"

enum { RAD_MAX_ISOLATED_NOTES = 20 }; /* surfaces or shells of one kind */

/**
 * Look for what radiates without being met. The scene knows its visibility.
 *
 * Refused: a flux below 0 on a face that sees nothing, because nothing arrives that could leave
 * there. Warned of: a flux on other faces that see nothing; closed shells (shell.h) that radiate
 * outwards, of which no other face of the scene sees anything; a scene of two faces or more in
 * which none sees another.
 *
 * @param[in]  path   of the deck, for messages
 * @param[out] notes  warnings are appended
 * @return RAD_OK, RAD_EINPUT, or RAD_ESYSTEM when out of memory. Cost n log n, and the rows of the
 *         table of visibility of faces that see nothing or are part of such a shell
 */
enum rad_code rad_check_isolated(const struct rad_scene *scene, const char *path,
                                 struct rad_notes *notes, struct rad_error *e);

#endif
