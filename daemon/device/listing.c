#include "device/listing.h"

#include "base/sha256.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define PREFIX "glint-"
#define MAX_PATH 512
#define MAX_OPTIONS 4096
#define MAX_FILES 256
#define DAY 86400.0

static bool hash_file(const char *path, char hex[65])
{
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    struct stat s;
    bool ok = fd >= 0 && !fstat(fd, &s) && S_ISREG(s.st_mode) && s.st_size > 0;
    void *bytes = ok ? mmap(NULL, (size_t)s.st_size, PROT_READ, MAP_PRIVATE, fd, 0) : MAP_FAILED;
    ok = bytes != MAP_FAILED;
    if (ok) {
        glint_sha256(bytes, (size_t)s.st_size, hex);
        munmap(bytes, (size_t)s.st_size);
    }
    if (fd >= 0)
        close(fd);
    return ok;
}

// A path that stays in the cache.
static bool is_inside(const char *path)
{
    return path[0] && path[0] != '/' && strlen(path) < MAX_PATH && !strstr(path, "..");
}

static FILE *open_listing(const char *cache, const char *key, const char *mode)
{
    char path[MAX_PATH * 2];
    snprintf(path, sizeof path, "%s/" PREFIX "%s", cache, key);
    return fopen(path, mode);
}

// The next file of a listing: 1; 0: there is none; -1: this is no listing.
static int next_file(FILE *in, char hex[65], char path[MAX_PATH])
{
    char line[MAX_PATH + 80];
    if (!fgets(line, sizeof line, in))
        return ferror(in) ? -1 : 0;
    if (sscanf(line, "%64[0-9a-f] %511[^\n]", hex, path) != 2 || !strchr(line, '\n'))
        return -1;
    return strlen(hex) == 64 && is_inside(path) ? 1 : -1;
}

static bool skip_options(FILE *in)
{
    int c;
    while ((c = getc(in)) != EOF && c != '\n')
        ;
    return c == '\n';
}

static bool holds(FILE *in, const char *cache)
{
    char listed[65], found[65], path[MAX_PATH], whole[MAX_PATH * 2];
    int files = 0, more = skip_options(in) ? 1 : -1;
    while (more > 0 && (more = next_file(in, listed, path)) > 0) {
        snprintf(whole, sizeof whole, "%s/%s", cache, path);
        if (!hash_file(whole, found) || strcmp(listed, found))
            return false;
        files++;
    }
    return more == 0 && files > 0;
}

static bool is_bitcode(const char *path)
{
    static const char name[] = "/program.bc";
    const size_t length = strlen(path);
    return length > sizeof name && !strcmp(path + length - (sizeof name - 1), name);
}

bool glint_listing_bitcode(const char *cache, const char *key, char *path, size_t capacity)
{
    char hex[65], inside[MAX_PATH];
    int found = 0;
    FILE *in = open_listing(cache, key, "re");
    bool more = in && skip_options(in);
    while (found < 2 && more && (more = next_file(in, hex, inside) > 0))
        if (is_bitcode(inside) && ++found == 1)
            snprintf(path, capacity, "%s/%s", cache, inside);
    if (in)
        fclose(in);
    return found == 2;
}

static void remove_listed(FILE *in, const char *cache)
{
    char hex[65], path[MAX_PATH], whole[MAX_PATH * 2];
    rewind(in);
    if (!skip_options(in))
        return;
    while (next_file(in, hex, path) > 0) {
        snprintf(whole, sizeof whole, "%s/%s", cache, path);
        unlink(whole);
    }
}

bool glint_listing_holds(const char *cache, const char *key)
{
    FILE *in = open_listing(cache, key, "re");
    const bool whole = in && holds(in, cache);
    if (whole)
        futimens(fileno(in), NULL);
    if (in)
        fclose(in);
    if (!whole)
        glint_listing_remove(cache, key);
    return whole;
}

void glint_listing_remove(const char *cache, const char *key)
{
    char path[MAX_PATH * 2];
    FILE *in = open_listing(cache, key, "re");
    if (!in)
        return;
    remove_listed(in, cache);
    fclose(in);
    snprintf(path, sizeof path, "%s/" PREFIX "%s", cache, key);
    unlink(path);
}

// ---- all of them

static bool is_key(const char *key)
{
    return strlen(key) == 64 && strspn(key, "0123456789abcdef") == 64;
}

static bool call_one(const char *cache, const char *key, glint_listing_fn *call, void *user)
{
    char options[MAX_OPTIONS];
    struct stat s;
    FILE *in = open_listing(cache, key, "re");
    bool ok = in && !fstat(fileno(in), &s) && fgets(options, sizeof options, in);
    if (in)
        fclose(in);
    char *end = ok ? strchr(options, '\n') : NULL;
    if (!end)
        return true;
    *end = 0;
    return call(user, key, options, difftime(time(NULL), s.st_mtime));
}

void glint_listing_each(const char *cache, glint_listing_fn *call, void *user)
{
    DIR *folder = opendir(cache);
    bool more = folder != NULL;
    for (const struct dirent *e; more && (e = readdir(folder));)
        if (!strncmp(e->d_name, PREFIX, strlen(PREFIX)) && is_key(e->d_name + strlen(PREFIX)))
            more = call_one(cache, e->d_name + strlen(PREFIX), call, user);
    if (folder)
        closedir(folder);
}

// ---- taking

struct taking {
    const char *cache, *from;
    FILE *list;
    char *file[MAX_FILES];
    int files;
    bool failed;
};

// nftw() has no argument for its caller.
static _Thread_local struct taking *taking;

static bool make_folders(char *path)
{
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = 0;
        const int failed = mkdir(path, 0700);
        *slash = '/';
        if (failed && errno != EEXIST)
            return false;
    }
    return true;
}

// The program itself comes from every process that compiled some of its kernels.
static bool is_taken(const char *inside)
{
    for (int i = 0; i < taking->files; i++)
        if (!strcmp(taking->file[i], inside))
            return true;
    return false;
}

static bool take_file(const char *from, const char *inside)
{
    char to[MAX_PATH * 2], hex[65];
    if (is_taken(inside))
        return true;
    snprintf(to, sizeof to, "%s/%s", taking->cache, inside);
    if (taking->files == MAX_FILES || !is_inside(inside) || !hash_file(from, hex) ||
        !make_folders(to) || rename(from, to))
        return false;
    char *copy = strdup(inside);
    if (!copy)
        return false;
    taking->file[taking->files++] = copy;
    fprintf(taking->list, "%s %s\n", hex, inside);
    return true;
}

// What PoCL leaves at the top of its folder is of no more use.
static int take_one(const char *path, const struct stat *s, int type, struct FTW *at)
{
    const char *inside = path + strlen(taking->from) + 1;
    if (type == FTW_F && at->level > 1 && s->st_size > 0)
        taking->failed = taking->failed || !take_file(path, inside);
    return 0;
}

// "XX/YYY" of the link to a program's folder.
static bool find_link(const char *part, char inside[MAX_PATH])
{
    char pattern[MAX_PATH * 2];
    glob_t all = {0};
    struct stat s;
    inside[0] = 0;
    snprintf(pattern, sizeof pattern, "%s/*/*", part);
    for (size_t i = glob(pattern, GLOB_NOESCAPE, NULL, &all) ? 0 : all.gl_pathc; i--;)
        if (!lstat(all.gl_pathv[i], &s) && S_ISLNK(s.st_mode))
            snprintf(inside, MAX_PATH, "%s", all.gl_pathv[i] + strlen(part) + 1);
    globfree(&all);
    return inside[0] != 0;
}

// Without it a program is still known by its source.
static void take_link(struct taking *t, const char *part, const char *inside)
{
    char from[MAX_PATH * 2], to[MAX_PATH * 2], file[MAX_PATH * 2 + 16], hex[65];
    snprintf(from, sizeof from, "%s/%s", part, inside);
    snprintf(to, sizeof to, "%s/%s", t->cache, inside);
    snprintf(file, sizeof file, "%s/program.bc", to);
    if (make_folders(to) && !rename(from, to) && hash_file(file, hex))
        fprintf(t->list, "%s %s/program.bc\n", hex, inside);
}

// The bitcode of two processes is not the same to the byte: that which the link is named for is
// taken, first.
static bool take_all(FILE *list, const char *cache, const char *const *made, int count)
{
    struct taking t = {.cache = cache, .list = list};
    char link[MAX_PATH] = "";
    int first = 0;
    while (first < count - 1 && !find_link(made[first], link))
        first++;
    const bool linked = find_link(made[first], link);
    taking = &t;
    for (int i = 0; i < count && !t.failed; i++) {
        t.from = made[(first + i) % count];
        t.failed = nftw(t.from, take_one, 16, FTW_PHYS) != 0;
    }
    taking = NULL;
    if (linked && !t.failed)
        take_link(&t, made[first], link);
    for (int i = 0; i < t.files; i++)
        free(t.file[i]);
    return !t.failed && t.files > 0;
}

bool glint_listing_take(const char *cache, const char *key, const char *options,
                        const char *const *made, int count)
{
    char path[MAX_PATH * 2], fresh[MAX_PATH * 2];
    snprintf(path, sizeof path, "%s/" PREFIX "%s", cache, key);
    snprintf(fresh, sizeof fresh, "%s/" PREFIX "%s.%ld", cache, key, (long)getpid());
    FILE *list = fopen(fresh, "we");
    if (!list)
        return false;
    fprintf(list, "%s\n", options);
    bool ok = take_all(list, cache, made, count);
    ok = fclose(list) == 0 && ok && rename(fresh, path) == 0;
    if (!ok)
        unlink(fresh);
    return ok;
}

static int remove_one(const char *path, const struct stat *s, int type, struct FTW *at)
{
    (void)s;
    (void)type;
    (void)at;
    remove(path); // what stays is a few bytes of a cache
    return 0;
}

void glint_folder_remove(const char *path)
{
    nftw(path, remove_one, 16, FTW_PHYS | FTW_DEPTH);
}

static bool is_litter(const char *cache, const char *name)
{
    char path[MAX_PATH * 2];
    struct stat s;
    snprintf(path, sizeof path, "%s/%s", cache, name);
    return (!strncmp(name, "making-", 7) || !strncmp(name, "tempfile_", 9)) && !lstat(path, &s) &&
           difftime(time(NULL), s.st_mtime) > DAY;
}

void glint_listing_sweep(const char *cache)
{
    char path[MAX_PATH * 2];
    DIR *folder = opendir(cache);
    for (const struct dirent *e; folder && (e = readdir(folder));)
        if (is_litter(cache, e->d_name)) {
            snprintf(path, sizeof path, "%s/%s", cache, e->d_name);
            glint_folder_remove(path);
        }
    if (folder)
        closedir(folder);
}
