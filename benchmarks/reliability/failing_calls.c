/* Calls of the system on files below a folder, of which the n-th fails with an error that is named.

   Loaded in front of the C library (LD_PRELOAD), below Python, HDF5 and SQLite alike. Glibc on Linux alone. */

#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/sendfile.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/xattr.h>
#include <unistd.h>

#define MOST_FILES 4096
#define MOST_CALLS 20000

static char folder[4096];
static int number, fails_at, calls, inside;
static char is_open[MOST_FILES];
static const char *names[MOST_CALLS];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

/* Let the call of a place, counted from 1, fail with an error; none of them at place 0. */
void fail(const char *below, int at, int error)
{
    snprintf(folder, sizeof folder, "%s", below);
    fails_at = at;
    number = error;
    calls = 0;
    inside = 1;
}

/* Tell how many calls there were so far. */
int counted(void) { return calls; }

/* Name a call by its place. */
const char *name_of(int place) { return place >= 1 && place <= MOST_CALLS ? names[place - 1] : ""; }

static int is_here(const char *path) { return inside && path && !strncmp(path, folder, strlen(folder)); }
static int is_ours(int handle) { return inside && handle >= 0 && handle < MOST_FILES && is_open[handle]; }

static int fails(const char *name)
{
    pthread_mutex_lock(&lock);
    if (calls < MOST_CALLS)
        names[calls] = name;
    int now = ++calls == fails_at;
    pthread_mutex_unlock(&lock);
    if (now)
        errno = number;
    return now;
}

static int noted(int handle, const char *path)
{
    if (handle >= 0 && handle < MOST_FILES)
        is_open[handle] = is_here(path);
    return handle;
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))
#define ON_PATH(type, name, path, declared, given)   \
    type name declared                               \
    {                                                \
        if (is_here(path) && fails(#name))           \
            return (type)-1;                         \
        return REAL(name) given;                     \
    }
#define ON_FILE(type, name, declared, given)         \
    type name declared                               \
    {                                                \
        if (is_ours(handle) && fails(#name))         \
            return (type)-1;                         \
        return REAL(name) given;                     \
    }
#define OPENS(name)                                                        \
    int name(const char *path, int flags, ...)                             \
    {                                                                      \
        va_list more;                                                      \
        va_start(more, flags);                                             \
        mode_t mode = va_arg(more, mode_t);                                \
        va_end(more);                                                      \
        if (is_here(path) && fails(flags & O_EXCL ? "create" : #name))     \
            return -1;                                                     \
        return noted(REAL(name)(path, flags, mode), path);                 \
    }
#define OPENS_AT(name)                                                     \
    int name(int at, const char *path, int flags, ...)                     \
    {                                                                      \
        va_list more;                                                      \
        va_start(more, flags);                                             \
        mode_t mode = va_arg(more, mode_t);                                \
        va_end(more);                                                      \
        if (is_here(path) && fails(#name))                                 \
            return -1;                                                     \
        return noted(REAL(name)(at, path, flags, mode), path);             \
    }

OPENS(open)
OPENS(open64)
OPENS_AT(openat)
OPENS_AT(openat64)

int close(int handle)
{
    if (handle >= 0 && handle < MOST_FILES)
        is_open[handle] = 0;
    return REAL(close)(handle);
}

DIR *opendir(const char *path)
{
    if (is_here(path) && fails("opendir"))
        return NULL;
    return REAL(opendir)(path);
}

ON_PATH(int, stat, path, (const char *path, struct stat *into), (path, into))
ON_PATH(int, stat64, path, (const char *path, struct stat64 *into), (path, into))
ON_PATH(int, lstat, path, (const char *path, struct stat *into), (path, into))
ON_PATH(int, lstat64, path, (const char *path, struct stat64 *into), (path, into))
ON_PATH(int, fstatat, path, (int at, const char *path, struct stat *into, int how), (at, path, into, how))
ON_PATH(int, fstatat64, path, (int at, const char *path, struct stat64 *into, int how), (at, path, into, how))
ON_PATH(int, statx, path, (int at, const char *path, int how, unsigned mask, struct statx *into), (at, path, how, mask, into))
ON_PATH(int, access, path, (const char *path, int mode), (path, mode))
ON_PATH(int, mkdir, path, (const char *path, mode_t mode), (path, mode))
ON_PATH(int, mkdirat, path, (int at, const char *path, mode_t mode), (at, path, mode))
ON_PATH(int, unlink, path, (const char *path), (path))
ON_PATH(int, unlinkat, path, (int at, const char *path, int how), (at, path, how))
ON_PATH(int, rename, path, (const char *path, const char *to), (path, to))
ON_PATH(int, renameat, path, (int at, const char *path, int there, const char *to), (at, path, there, to))
ON_PATH(int, chmod, path, (const char *path, mode_t mode), (path, mode))
ON_PATH(int, fchmodat, path, (int at, const char *path, mode_t mode, int how), (at, path, mode, how))
ON_PATH(int, chown, path, (const char *path, uid_t user, gid_t group), (path, user, group))
ON_PATH(ssize_t, readlink, path, (const char *path, char *into, size_t size), (path, into, size))
ON_PATH(ssize_t, getxattr, path, (const char *path, const char *name, void *value, size_t size), (path, name, value, size))
ON_PATH(int, setxattr, path, (const char *path, const char *name, const void *value, size_t size, int how), (path, name, value, size, how))

ON_FILE(int, fstat, (int handle, struct stat *into), (handle, into))
ON_FILE(int, fstat64, (int handle, struct stat64 *into), (handle, into))
ON_FILE(ssize_t, read, (int handle, void *into, size_t size), (handle, into, size))
ON_FILE(ssize_t, pread, (int handle, void *into, size_t size, off_t at), (handle, into, size, at))
ON_FILE(ssize_t, pread64, (int handle, void *into, size_t size, off64_t at), (handle, into, size, at))
ON_FILE(ssize_t, write, (int handle, const void *from, size_t size), (handle, from, size))
ON_FILE(ssize_t, pwrite, (int handle, const void *from, size_t size, off_t at), (handle, from, size, at))
ON_FILE(ssize_t, pwrite64, (int handle, const void *from, size_t size, off64_t at), (handle, from, size, at))
ON_FILE(int, fsync, (int handle), (handle))
ON_FILE(int, fdatasync, (int handle), (handle))
ON_FILE(int, ftruncate, (int handle, off_t size), (handle, size))
ON_FILE(int, ftruncate64, (int handle, off64_t size), (handle, size))
ON_FILE(int, fchmod, (int handle, mode_t mode), (handle, mode))
ON_FILE(ssize_t, sendfile, (int into, int handle, off_t *at, size_t size), (into, handle, at, size))
ON_FILE(ssize_t, sendfile64, (int into, int handle, off64_t *at, size_t size), (into, handle, at, size))
ON_FILE(ssize_t, copy_file_range, (int handle, off64_t *at, int into, off64_t *there, size_t size, unsigned how), (handle, at, into, there, size, how))
ON_FILE(int, flock, (int handle, int how), (handle, how))
