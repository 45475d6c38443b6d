#include "proto/format.h"

#include "proto/text.h"

#include <ctype.h>
#include <string.h>
#include <strings.h>

#define MESH(suffix) "convert it with assimp export in." suffix " out.ply -jiv"
#define PDAL(suffix) "convert it with pdal translate in." suffix " out.ply"
#define HELP "convert it as \"voronoid help formats\" says"
#define PAGE "it is probably an error page instead of the file: download it again"
#define NO_CLOUD "it is not a point cloud"

enum { LOOKED_AT = 4096, LINES = 3 }; /* bytes, and lines of text, that are looked at */

/* Without case: HTML and CSV are written in any. */
static int begins(const char *text, size_t size, const char *with)
{
    size_t length = strlen(with);

    return size >= length && strncasecmp(text, with, length) == 0;
}

static int begins_one_of(const char *text, size_t size, const char *const *words, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (begins(text, size, words[i]))
            return 1;
    return 0;
}

static int holds(const char *text, size_t size, const char *word)
{
    for (size_t i = 0; i < size; i++)
        if (begins(text + i, size - i, word))
            return 1;
    return 0;
}

static void skip(const char **text, size_t *size, size_t length)
{
    *text += length;
    *size -= length;
    while (*size > 0 && isspace((unsigned char)**text)) {
        (*text)++;
        (*size)--;
    }
}

/* To the next line that is neither blank nor a comment. */
static void skip_line(const char **text, size_t *size, size_t length)
{
    skip(text, size, length);
    while (begins(*text, *size, "#") || begins(*text, *size, "//"))
        skip(text, size, vor_line_length(*text, *size));
}

/* Counts the numbers of a line: 0 if anything else stands in it. */
static size_t count_numbers(const char *line, size_t length)
{
    static const char between[] = " \t,;", parts[] = "+-.0123456789eE";
    size_t count = 0;

    for (size_t i = 0; i < length;) {
        size_t begin = i;

        if (memchr(between, line[i], sizeof between - 1) != NULL) {
            i++;
            continue;
        }
        while (i < length && memchr(parts, line[i], sizeof parts - 1) != NULL)
            i++;
        if (i == begin || (i < length && memchr(between, line[i], sizeof between - 1) == NULL))
            return 0;
        count++;
    }
    return count;
}

/* Of the first lines that are no comments. */
static void count_lines(const char *text, size_t size, size_t out[LINES])
{
    size_t length = 0;

    for (int i = 0; i < LINES; i++) {
        skip_line(&text, &size, length);
        length = vor_line_length(text, size);
        out[i] = count_numbers(text, length);
    }
}

static int looks_pts(const char *text, size_t size)
{
    size_t in[LINES];

    count_lines(text, size, in);
    return in[0] == 1 && in[1] >= 3;
}

/* Columns, rows, and the place of the scanner. */
static int looks_ptx(const char *text, size_t size)
{
    size_t in[LINES];

    count_lines(text, size, in);
    return in[0] == 1 && in[1] == 1 && in[2] == 3;
}

/* The first line may name the columns. */
static int looks_numbers(const char *text, size_t size)
{
    size_t in[LINES];

    count_lines(text, size, in);
    return in[0] >= 3 || (in[0] == 0 && in[1] >= 3);
}

static int looks_pcd(const char *text, size_t size)
{
    skip_line(&text, &size, 0);
    return begins(text, size, "VERSION ") && holds(text, size, "FIELDS ");
}

static int looks_obj(const char *text, size_t size)
{
    static const char *const words[] = {"v ", "vn ", "vt ", "mtllib ", "o ", "g "};

    skip_line(&text, &size, 0);
    return begins_one_of(text, size, words, sizeof words / sizeof words[0]);
}

static int looks_off(const char *text, size_t size)
{
    static const char *const words[] = {"OFF", "COFF", "NOFF", "CNOFF", "STOFF", "4OFF"};

    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++) {
        size_t length = strlen(words[i]);

        if (begins(text, size, words[i]) && size > length && isspace((unsigned char)text[length]))
            return 1;
    }
    return 0;
}

static int looks_ascii_stl(const char *text, size_t size)
{
    return begins(text, size, "solid") && holds(text, size, "facet");
}

/* 80 bytes for anybody, the number of triangles, and the first of them, whose normal is a unit. */
static int looks_binary_stl(const char *bytes, size_t size)
{
    static const char none[4] = {0};
    float normal[3];
    double square = 0;

    if (size < 84 + 50 || memcmp(bytes + 80, none, sizeof none) == 0)
        return 0;
    memcpy(normal, bytes + 84, sizeof normal);
    for (int i = 0; i < 3; i++)
        square += (double)normal[i] * normal[i];
    return square > 0.99 && square < 1.01;
}

static int looks_gltf(const char *text, size_t size)
{
    return begins(text, size, "{") && holds(text, size, "\"asset\"");
}

static int looks_json(const char *text, size_t size)
{
    char first;

    skip(&text, &size, 0);
    if (size == 0 || (*text != '{' && *text != '['))
        return 0;
    first = *text;
    skip(&text, &size, 1);
    return size == 0 || *text == '"' || (first == '[' && strchr("{[-0123456789", *text) != NULL);
}

static int looks_html(const char *text, size_t size)
{
    static const char *const words[] = {"<!doctype", "<html", "<head", "<body"};

    skip(&text, &size, 0);
    return begins_one_of(text, size, words, sizeof words / sizeof words[0]);
}

/* The point format of LAS has this bit where LASzip packs the points. */
static int looks_laz(const char *bytes, size_t size)
{
    return size > 104 && memcmp(bytes, "LASF", 4) == 0 && (bytes[104] & 0x80) != 0;
}

/* NumPy's arrays in a ZIP: the name of the first file begins at byte 30. */
static int looks_npz(const char *bytes, size_t size)
{
    return size > 30 && memcmp(bytes, "PK\3\4", 4) == 0 &&
           holds(bytes + 30, size - 30 < 64 ? size - 30 : 64, ".npy");
}

/* What has no magic is recognised by a function. Rows are asked in order. */
static const struct {
    struct vor_foreign is;
    size_t at, length; /* of the magic */
    const char *magic;
    int (*looks)(const char *bytes, size_t size);
} rows[] = {
#define MAGIC(name, at, magic, hint)                                                               \
    {                                                                                              \
        {name, hint}, at, sizeof(magic) - 1, magic, NULL                                           \
    }
#define LOOKS(name, looks, hint)                                                                   \
    {                                                                                              \
        {name, hint}, 0, 0, NULL, looks                                                            \
    }
    LOOKS("LAZ", looks_laz, PDAL("laz")),
    MAGIC("LAS", 0, "LASF", PDAL("las")),
    MAGIC("E57", 0, "ASTM-E57", PDAL("e57")),
    LOOKS("PCD", looks_pcd, "convert it with pcl_pcd2ply in.pcd out.ply"),
    MAGIC("VTK", 0, "# vtk DataFile", "convert it with pcl_vtk2ply in.vtk out.ply"),
    MAGIC("VTK in XML", 0, "<VTKFile", "save it as PLY in ParaView"),
    MAGIC("glTF (GLB)", 0, "glTF", MESH("glb")),
    LOOKS("glTF", looks_gltf, MESH("gltf")),
    MAGIC("FBX", 0, "Kaydara FBX", MESH("fbx")),
    LOOKS("STL", looks_ascii_stl, MESH("stl")),
    LOOKS("OFF", looks_off, MESH("off")),
    LOOKS("OBJ", looks_obj, MESH("obj")),
    LOOKS("NPZ", looks_npz, HELP),
    MAGIC("NPY", 0, "\x93NUMPY", HELP),
    MAGIC("a ROS bag", 0, "#ROSBAG V",
          "rosrun pcl_ros bag_to_pcd in.bag TOPIC DIR writes PCD files, which pcl_pcd2ply converts "
          "to PLY"),
    MAGIC("MCAP", 0, "\x89MCAP0\r\n",
          "export its clouds as PCD files, which pcl_pcd2ply converts to PLY"),
    MAGIC("HDF5", 0, "\x89HDF\r\n", "export its points as PLY"),
    MAGIC("gzip", 0, "\x1f\x8b",
          "unpack it with gunzip, or send it over HTTP with Content-Encoding: gzip"),
    MAGIC("ZIP", 0, "PK\3\4", "unpack it with unzip"),
    MAGIC("bzip2", 0, "BZh", "unpack it with bunzip2"),
    MAGIC("xz", 0, "\3757zXZ", "unpack it with unxz"),
    MAGIC("Zstandard", 0, "\x28\xb5\x2f\xfd", "unpack it with unzstd"),
    MAGIC("7z", 0, "7z\xbc\xaf\x27\x1c", "unpack it with 7z x"),
    MAGIC("RAR", 0, "Rar!\x1a\7", "unpack it with unrar x"),
    MAGIC("tar", 257, "ustar", "unpack it with tar xf"),
    MAGIC("PNG", 0, "\x89PNG\r\n", NO_CLOUD),
    MAGIC("JPEG", 0, "\xff\xd8\xff", NO_CLOUD),
    MAGIC("PDF", 0, "%PDF-", NO_CLOUD),
    MAGIC("a pointer of Git LFS", 0, "version https://git-lfs", "fetch the file: git lfs pull"),
    MAGIC("UTF-16", 0, "\xff\xfe", "a PLY file has to be ASCII or UTF-8"),
    MAGIC("UTF-16", 0, "\xfe\xff", "a PLY file has to be ASCII or UTF-8"),
    LOOKS("HTML", looks_html, PAGE),
    LOOKS("JSON", looks_json, "it is probably an error message, or parameters instead of a cloud"),
    MAGIC("XML", 0, "<?xml", PAGE),
    LOOKS("PTX", looks_ptx, PDAL("ptx")),
    LOOKS("PTS", looks_pts, PDAL("pts")),
    LOOKS("numbers in text (XYZ, CSV)", looks_numbers, HELP),
    LOOKS("STL", looks_binary_stl, MESH("stl")),
};

const struct vor_foreign *vor_foreign_sniff(const uint8_t *bytes, size_t size)
{
    const char *text = (const char *)bytes;
    size_t seen = size < LOOKED_AT ? size : LOOKED_AT;
    size_t mark = begins(text, seen, "\xef\xbb\xbf") ? 3 : 0; /* the byte order mark of UTF-8 */

    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        size_t at = rows[i].at, length = rows[i].length;

        if (length > 0 && seen >= at + length && memcmp(bytes + at, rows[i].magic, length) == 0)
            return &rows[i].is;
        if (rows[i].looks != NULL && rows[i].looks(text + mark, seen - mark))
            return &rows[i].is;
    }
    return NULL;
}
