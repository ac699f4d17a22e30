/* How much memory there is, how much was used, and one place to ask for large blocks. */
#ifndef RAD_BASE_MEMORY_H
#define RAD_BASE_MEMORY_H

#include <stddef.h>

/* Bytes this process may still take: the least of free RAM, ulimit -v/-d and the cgroup's rest. */
double rad_memory_available(void);

/* Bytes of address space that the C library and BLAS keep for threads at work, which count only
 * where ulimit -v limits it; else 0. */
double rad_memory_reserved(int n_thread);

/* Resident size now [bytes]: the libraries, and what has been made so far. */
double rad_memory_resident(void);

/* Largest resident size so far [bytes]. */
double rad_memory_peak(void);

enum { RAD_BEYOND = 64 }; /* bytes after the last that may be read: a vector register */

/* Zeroed pages from the system, untouched ones cost nothing; huge pages where offered. NULL if
 * none. RAD_BEYOND bytes more may be read, not written. */
void *rad_pages_alloc(size_t bytes);
void rad_pages_free(void *pages, size_t bytes); /* NULL is fine */

/* malloc/calloc of n items, NULL on overflow or when n is 0 is never returned (at least 1 byte). */
void *rad_alloc(size_t n, size_t item);
void *rad_calloc(size_t n, size_t item);

/* Room for at least n items in *array, which may be NULL; grows to twice the room or more.
 * Returns 0 without memory: array and room are as they were. */
int rad_reserve(void **array, size_t n, size_t *room, size_t item);

#endif
