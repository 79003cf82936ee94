/* Makes the disk below $SLOW_FOLDER slow for a process, while the file $SLOW_WHILE is there: by LD_PRELOAD. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static void wait_for_the_disk(int fd)
{
    const char *folder = getenv("SLOW_FOLDER"), *meanwhile = getenv("SLOW_WHILE");
    char link[64], path[4096];
    if (!folder || !meanwhile || access(meanwhile, F_OK))
        return;
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length < 0)
        return;
    path[length] = 0;
    if (strncmp(path, folder, strlen(folder)))
        return;
    struct timespec pause = {atoi(getenv("SLOW_SECONDS")), 0};
    nanosleep(&pause, NULL);
}

ssize_t write(int fd, const void *data, size_t size)
{
    static ssize_t (*next)(int, const void *, size_t);
    if (!next)
        next = (ssize_t (*)(int, const void *, size_t))dlsym(RTLD_NEXT, "write");
    wait_for_the_disk(fd);
    return next(fd, data, size);
}

int fsync(int fd)
{
    static int (*next)(int);
    if (!next)
        next = (int (*)(int))dlsym(RTLD_NEXT, "fsync");
    wait_for_the_disk(fd);
    return next(fd);
}
