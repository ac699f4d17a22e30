/* Shared by the tests of the deck reader. */
#ifndef POLYRAD_TEST_DECK_HELP_H
#define POLYRAD_TEST_DECK_HELP_H

#include <stddef.h>

#include "scene/deck.h"

#define COUNT(a) ((int)(sizeof(a) / sizeof *(a)))

#define TRIANGLE "{vertices: [[0,0,0],[1,0,0],[0,1,0]], rho: 0.5, emission: 1}"
#define SCENE "scene: {triangles: [" TRIANGLE "]}\n"

enum { FULL_DECK = 2000 };
extern const char full_deck[FULL_DECK]; /* every key; zeros at the end */

extern char deck_path[64]; /* of the last deck written */
void write_deck(const char *text, size_t n);

/* Write the text, read it as a deck with overrides, and remove the file. */
enum rad_code read_text(const char *text, int n_set, const char *const *set, struct rad_deck *deck,
                        struct rad_error *e);
void read_good(const char *text, int n_set, const char *const *set, struct rad_deck *deck);

#endif
