/* Makes the disk below $BAD_FOLDER bad for a process, while the file $BAD_WHILE is there: by LD_PRELOAD.

   With $BAD_SECONDS each write takes so long; with $BAD_ERRNO it is refused with that error. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static int is_bad(int fd)
{
    const char *folder = getenv("BAD_FOLDER"), *meanwhile = getenv("BAD_WHILE");
    char link[64], path[4096];
    if (!folder || !meanwhile || access(meanwhile, F_OK))
        return 0;
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length < 0)
        return 0;
    path[length] = 0;
    return !strncmp(path, folder, strlen(folder));
}

static int is_refused(int fd)
{
    if (!is_bad(fd))
        return 0;
    if (getenv("BAD_ERRNO")) {
        errno = atoi(getenv("BAD_ERRNO"));
        return 1;
    }
    struct timespec pause = {atoi(getenv("BAD_SECONDS")), 0};
    nanosleep(&pause, NULL);
    return 0;
}

ssize_t write(int fd, const void *data, size_t size)
{
    static ssize_t (*next)(int, const void *, size_t);
    if (!next)
        next = (ssize_t (*)(int, const void *, size_t))dlsym(RTLD_NEXT, "write");
    return is_refused(fd) ? -1 : next(fd, data, size);
}

int fsync(int fd)
{
    static int (*next)(int);
    if (!next)
        next = (int (*)(int))dlsym(RTLD_NEXT, "fsync");
    return is_refused(fd) ? -1 : next(fd);
}
