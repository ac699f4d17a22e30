/* The files of a command, before it begins to work. */
#ifndef RAD_APP_FILES_H
#define RAD_APP_FILES_H

#include "app/command.h"
#include "scene/deck.h"

/**
 * See that nothing that was given would be written over, and that what is to be written can be.
 *
 * Given are the files of the command line (deck, parts, tasks), its --restart, and the meshes that
 * the deck names, those of the runs of its study too. Written are `output` and --checkpoint, which
 * may be the file of --restart.
 *
 * @param[in] deck    read, or NULL: the command has none
 * @param[in] output  where the result, table or part goes
 * @return RAD_EINPUT for an output that is a file given, or the other output, or no file at all (a
 *         pipe); RAD_ESYSTEM where nothing can be written
 */
enum rad_code rad_files_check(const struct rad_command *command, const struct rad_deck *deck,
                              const char *output, struct rad_error *e);

#endif
