#include "output/save.h"

#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { STEP = 1 << 20 };

static const char *remedy(int cause) {
  switch (cause) {
  case ENOENT:
  case ENOTDIR:
    return "create its folder first, or name another file";
  case EACCES:
  case EPERM:
  case EROFS:
    return "name a file and folder that you may write to";
  case ENOSPC:
  case EDQUOT:
    return "free some space, or name a file on another disk";
  case EFBIG:
    return "raise the limit on file sizes (ulimit -f), or lower output.sampling";
  case EISDIR:
    return "name a file, not a folder";
  case ENAMETOOLONG:
    return "give a shorter one: .PID.tmp is added to it while it is written";
  default:
    return "name another file, or look into the disk's state";
  }
}

static enum rad_code fail(const char *path, int cause, struct rad_error *e) {
  return rad_fail(e, RAD_ESYSTEM, "cannot write %.600s: %s; %s", path, strerror(cause),
                  remedy(cause));
}

/* The calls below return 0 or an errno: errno itself would not survive the clean-up between. */

int rad_write_all(int fd, const void *bytes, size_t size) {
  const char *at = bytes;
  while (size > 0) {
    const ssize_t n = write(fd, at, size);
    if (n < 0 && errno != EINTR)
      return errno;
    if (n > 0) {
      at += n;
      size -= (size_t)n;
    }
  }
  return 0;
}

int rad_copy_part(int from, int to, off_t at, off_t end) {
  char *bytes = malloc(STEP);
  int cause = bytes ? 0 : ENOMEM;
  while (!cause && at < end) {
    const ssize_t n = pread(from, bytes, end - at < STEP ? (size_t)(end - at) : STEP, at);
    if (n <= 0)
      cause = n < 0 ? errno : EIO;
    else if (lseek(to, at, SEEK_SET) < 0)
      cause = errno;
    else
      cause = rad_write_all(to, bytes, (size_t)n);
    at += n;
  }
  free(bytes);
  return cause;
}

struct block {
  const void *bytes;
  size_t size;
};

static int fill_block(int fd, void *context) {
  const struct block *b = context;
  return rad_write_all(fd, b->bytes, b->size);
}

/* Data, then the disk's word that it has them. Pipes and some devices cannot sync: EINVAL. */
static int fill_and_close(int fd, rad_save_filler *fill, void *context) {
  int cause = fill(fd, context);
  if (!cause && fsync(fd) != 0 && errno != EINVAL && errno != EROFS)
    cause = errno;
  if (close(fd) != 0 && !cause)
    cause = errno;
  return cause;
}

/* A .tmp of this name is left over from a dead process that had our number. */
static int open_new(const char *name) {
  const int flags = O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC;
  int fd = open(name, flags, 0666);
  if (fd < 0 && errno == EEXIST && unlink(name) == 0)
    fd = open(name, flags, 0666);
  return fd;
}

/* The rename is on disk once the folder is. Best effort: the data are safe already. */
static void sync_folder(const char *path) {
  char *copy = strdup(path);
  if (!copy)
    return;
  const int fd = open(dirname(copy), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd >= 0) {
    (void)fsync(fd);
    close(fd);
  }
  free(copy);
}

char *rad_save_temporary(const char *path) {
  const size_t room = strlen(path) + 32;
  char *temporary = malloc(room);
  if (temporary)
    snprintf(temporary, room, "%s.%ld.tmp", path, (long)getpid());
  return temporary;
}

static int save_and_rename(const char *path, rad_save_filler *fill, void *context) {
  char *temporary = rad_save_temporary(path);
  if (!temporary)
    return ENOMEM;
  const int fd = open_new(temporary);
  int cause = fd < 0 ? errno : fill_and_close(fd, fill, context);
  if (!cause && rename(temporary, path) != 0)
    cause = errno;
  if (cause && fd >= 0)
    unlink(temporary);
  if (!cause)
    sync_folder(path);
  free(temporary);
  return cause;
}

static int save_to_device(const char *path, rad_save_filler *fill, void *context) {
  const int fd = open(path, O_WRONLY | O_CLOEXEC);
  return fd < 0 ? errno : fill_and_close(fd, fill, context);
}

enum rad_code rad_save(const char *path, const void *bytes, size_t size, struct rad_error *e) {
  struct block b = {bytes, size};
  return rad_save_by(path, fill_block, &b, e);
}

/* The system's links to open files. */
static int is_link_of_system(const char *path) {
  struct stat link;
  const int of_system = !strncmp(path, "/dev/", 5) || !strncmp(path, "/proc/", 6);
  return of_system && !lstat(path, &link) && S_ISLNK(link.st_mode);
}

/* Things that cannot be replaced. */
static int is_device(const char *path, const struct stat *is) {
  return !S_ISREG(is->st_mode) || is_link_of_system(path);
}

const char *rad_save_obstacle(const char *path) {
  struct stat is;
  if (stat(path, &is) != 0 || is_link_of_system(path))
    return NULL;
  return S_ISFIFO(is.st_mode)   ? "a named pipe"
         : S_ISSOCK(is.st_mode) ? "a socket"
         : S_ISBLK(is.st_mode)  ? "a disk"
                                : NULL;
}

/* Write to whatever there is at path. */
static int save_anywhere(const char *path, rad_save_filler *fill, void *context) {
  struct stat is;
  if (stat(path, &is) != 0)
    return save_and_rename(path, fill, context);
  if (S_ISDIR(is.st_mode))
    return EISDIR;
  if (is_device(path, &is))
    return save_to_device(path, fill, context);
  if (faccessat(AT_FDCWD, path, W_OK, AT_EACCESS) != 0)
    return errno;
  return save_and_rename(path, fill, context);
}

enum rad_code rad_save_by(const char *path, rad_save_filler *fill, void *context,
                          struct rad_error *e) {
  const int cause = save_anywhere(path, fill, context);
  return cause ? fail(path, cause, e) : RAD_OK;
}

/* An empty file of the temporary name, made and removed: folder, rights and length of the name. */
static int try_new(const char *path) {
  char *temporary = rad_save_temporary(path);
  const int fd = temporary ? open_new(temporary) : -1, cause = fd < 0 ? errno : 0;
  if (fd >= 0) {
    close(fd);
    unlink(temporary);
  }
  free(temporary);
  return cause;
}

static int try_anywhere(const char *path) {
  struct stat is;
  const int is_there = stat(path, &is) == 0;
  if (is_there && S_ISDIR(is.st_mode))
    return EISDIR;
  if (is_there && faccessat(AT_FDCWD, path, W_OK, AT_EACCESS) != 0)
    return errno;
  return is_there && is_device(path, &is) ? 0 : try_new(path);
}

enum rad_code rad_save_try(const char *path, struct rad_error *e) {
  const int cause = try_anywhere(path);
  return cause ? fail(path, cause, e) : RAD_OK;
}
