/* Reads a .pelage package, version 1 to 3: header, table, checksums, the manifest's texture names, mesh counts, fins
 * and texture sizes. Prints one line for each. On a fault, prints its position and exits with 1. Written from FORMAT.md
 * alone.
 *
 *     cc -std=c99 -o read_pelage read_pelage.c && ./read_pelage fox.pelage
 */
#include <inttypes.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const uint8_t *file;
static uint64_t file_length, version;
/* From manifest, mesh and fins, which may stand in any order behind the manifest. */
static uint64_t part_count, slab_count, vertex_count, first_fin, fin_count;

static void fail(const char *what, uint64_t offset)
{
    fprintf(stderr, "%s at byte %" PRIu64 "\n", what, offset);
    exit(1);
}

static uint64_t number(uint64_t offset, int bytes)
{
    uint64_t value = 0;
    int i;
    if (offset > file_length || file_length - offset < (uint64_t)bytes)
        fail("the file ends inside a number", offset);
    for (i = bytes - 1; i >= 0; i--)
        value = value << 8 | file[offset + (uint64_t)i];
    return value;
}

static uint32_t crc_update(uint32_t crc, const uint8_t *bytes, uint64_t count)
{
    uint64_t i;
    int bit;
    for (i = 0; i < count; i++) {
        crc ^= bytes[i];
        for (bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? UINT32_C(0xedb88320) : 0);
    }
    return crc;
}

static void expect_zero(uint64_t from, uint64_t to)
{
    for (; from < to; from++)
        if (number(from, 1) != 0)
            fail("expected a zero byte", from);
}

static uint64_t align(uint64_t offset)
{
    return (offset + 15) / 16 * 16;
}

/* A walk through the encoded values of a section. */
struct cursor {
    uint64_t at, end;
};

static uint64_t take(struct cursor *c, int bytes)
{
    uint64_t value;
    if (c->end - c->at < (uint64_t)bytes)
        fail("the section ends inside a value", c->at);
    value = number(c->at, bytes);
    c->at += (uint64_t)bytes;
    return value;
}

static void skip(struct cursor *c, uint64_t bytes)
{
    if (c->end - c->at < bytes)
        fail("a length is greater than the section", c->at);
    c->at += bytes;
}

static void skip_string(struct cursor *c)
{
    skip(c, take(c, 8));
}

/* Takes the byte of a bool or option. */
static int flag(struct cursor *c)
{
    uint64_t value = take(c, 1);
    if (value > 1)
        fail("expected 0 or 1", c->at - 1);
    return (int)value;
}

static void print_string(const char *name, struct cursor *c)
{
    uint64_t length = take(c, 8), at = c->at;
    skip(c, length);
    printf("%s ", name);
    fwrite(file + at, 1, (size_t)length, stdout);
    printf("\n");
}

static void skip_option(struct cursor *c, int bytes)
{
    if (flag(c))
        skip(c, (uint64_t)bytes);
}

static void read_choice(struct cursor *c)
{
    uint64_t n, k, bytes;
    skip_option(c, 8); /* limits */
    skip_option(c, 8);
    skip_option(c, 8);
    print_string("choice binding", c);
    skip_string(c); /* adapter */
    printf("choice of %" PRIu64, take(c, 4));
    printf(" by %" PRIu64 "\n", take(c, 4));
    skip(c, 4); /* samples */
    for (n = take(c, 8); n > 0; n--)
        print_string("view", c);
    for (n = take(c, 8); n > 0; n--) { /* trials */
        for (k = take(c, 8); k > 0; k--)
            print_string("setting", c);
        skip_option(c, 8); /* error */
        skip_option(c, 8); /* time */
        bytes = take(c, 8);
        printf("trial bytes %" PRIu64 " predicted %d\n", bytes, flag(c));
    }
    printf("chosen %" PRIu64 "\n", take(c, 4));
    skip_option(c, 4); /* next better */
    skip_option(c, 4); /* next cheaper */
}

static void read_manifest(struct cursor c)
{
    uint64_t n;
    print_string("generator", &c);
    print_string("model", &c);
    skip_string(&c); /* recipe */
    for (n = take(&c, 8); n > 0; n--) { /* inputs */
        skip_string(&c);
        skip_string(&c);
        skip(&c, 8 + 32);
    }
    skip(&c, 4 * (3 + 3 + 3 + 1)); /* bounds */
    printf("fur layers %" PRIu64, take(&c, 4));
    printf(" texels %" PRIu64 "\n", take(&c, 4));
    skip(&c, 4 + 4 + 4 + 4 + 4 + 4);
    if (version > 1 && flag(&c)) { /* wet */
        printf("wet color %" PRIu64, take(&c, 4));
        printf(" direction %" PRIu64 "\n", take(&c, 4));
    }
    if (version > 1 && flag(&c)) { /* fins */
        uint64_t width = take(&c, 4), height = take(&c, 4);
        slab_count = take(&c, 4);
        skip(&c, 4 + 4);
        printf("fin texels %" PRIu64 " by %" PRIu64 " slabs %" PRIu64 "\n", width, height, slab_count);
    }
    skip(&c, 4 * (3 + 3 + 3 + 4)); /* shading */
    for (n = take(&c, 8); n > 0; n--) { /* materials */
        print_string("material", &c);
        skip(&c, 4 * 4);
        if (flag(&c)) /* base colour texture */
            skip(&c, 4);
        if (version > 1 && flag(&c))
            printf("groom texture %" PRIu64 "\n", take(&c, 4));
        if (flag(&c)) /* alpha cutoff */
            skip(&c, 4);
        flag(&c);
        flag(&c);
    }
    part_count = take(&c, 8);
    for (n = part_count; n > 0; n--) { /* parts */
        uint64_t material = take(&c, 4), first = take(&c, 4), count = take(&c, 4);
        printf("part material %" PRIu64 " first %" PRIu64 " count %" PRIu64 "\n", material, first, count);
    }
    for (n = take(&c, 8); n > 0; n--) /* textures */
        print_string("texture", &c);
    for (n = take(&c, 8); n > 0; n--) { /* quality */
        skip_string(&c);
        skip(&c, 8);
        skip_string(&c);
    }
    for (n = take(&c, 8); n > 0; n--) /* warnings */
        print_string("warning", &c);
    if (version > 2) {
        if (flag(&c)) { /* coat */
            printf("coat height bits %" PRIu64 "\n", take(&c, 4));
            skip(&c, 4 + 4 + 4);
        }
        for (n = take(&c, 8); n > 0; n--) { /* levels of detail */
            printf("detail step %" PRIu64, take(&c, 4));
            printf(" full bits %" PRIu64 "\n", take(&c, 4));
            skip(&c, 4 + 4 + 4);
        }
        if (flag(&c))
            read_choice(&c);
    }
    if (c.at != c.end)
        fail("bytes follow the manifest", c.at);
}

static void read_mesh(uint64_t at, uint64_t length)
{
    uint64_t vertices, indices, flags, attributes, skin, index, k;
    if (length < 64)
        fail("the mesh has no header", at);
    vertices = number(at, 4);
    indices = number(at + 4, 4);
    flags = number(at + 8, 4);
    if (flags > 1)
        fail("unknown mesh flags", at + 8);
    expect_zero(at + 12, at + 16);
    expect_zero(at + 48, at + 64);
    attributes = align(64 + 48 * vertices);
    skin = align(attributes + 24 * vertices);
    index = align(skin + 24 * vertices * flags);
    if (number(at + 16, 8) != 64 || number(at + 24, 8) != attributes || number(at + 32, 8) != skin ||
        number(at + 40, 8) != index || index + 4 * indices != length)
        fail("the mesh's offsets do not follow from its counts", at + 16);
    /* What version 1 reserves in each vertex; of the groom of later ones half has no meaning yet. */
    for (k = 0; k < vertices; k++) {
        if (version == 1)
            expect_zero(at + 64 + 48 * k + 28, at + 64 + 48 * k + 32);
        expect_zero(at + attributes + 24 * k + (version == 1 ? 20 : 22), at + attributes + 24 * k + 24);
    }
    vertex_count = vertices;
    expect_zero(at + 64 + 48 * vertices, at + attributes);
    expect_zero(at + attributes + 24 * vertices, at + skin);
    expect_zero(at + skin + 24 * vertices * flags, at + index);
    printf("mesh vertices %" PRIu64 " indices %" PRIu64 " skin %" PRIu64 "\n", vertices, indices, flags);
    for (; indices > 0; indices--, index += 4)
        if (number(at + index, 4) >= vertices)
            fail("an index is not less than the vertex count", at + index);
}

static void read_fins(uint64_t at, uint64_t length)
{
    uint64_t count, parts, first, sum = 0, k;
    if (length < 16)
        fail("the fins have no header", at);
    count = number(at, 4);
    parts = number(at + 4, 4);
    first = align(16 + 4 * parts);
    if (number(at + 8, 8) != first || first + 24 * count != length || parts != part_count)
        fail("the fins' offset and length do not follow from their counts", at);
    printf("fins %" PRIu64 "\n", count);
    for (k = 0; k < parts; k++) {
        sum += number(at + 16 + 4 * k, 4);
        printf("part fins %" PRIu64 "\n", number(at + 16 + 4 * k, 4));
    }
    expect_zero(at + 16 + 4 * parts, at + first);
    if (sum != count)
        fail("the parts' fins do not add up", at + 16);
    for (k = 0; k < count; k++) {
        uint64_t fin = at + first + 24 * k, a = number(fin, 4), b = number(fin + 4, 4), slab = number(fin + 16, 4);
        if (a == b || slab >= slab_count)
            fail("a fin does not stand on two vertices, or shows no slab", fin);
        printf("fin %" PRIu64 " %" PRIu64 " slab %" PRIu64 "\n", a, b, slab);
    }
    first_fin = at + first;
    fin_count = count;
}

static void read_texture(uint64_t at, uint64_t length)
{
    static const uint8_t magic[12] = {0xab, 'K', 'T', 'X', ' ', '2', '0', 0xbb, '\r', '\n', 0x1a, '\n'};
    uint64_t layers;
    if (length < 80 || memcmp(file + at, magic, 12) != 0)
        fail("expected a KTX2 file", at);
    layers = number(at + 32, 4);
    printf("ktx2 format %" PRIu64 " width %" PRIu64 " height %" PRIu64 " layers %" PRIu64 " levels %" PRIu64 "\n",
           number(at + 12, 4), number(at + 20, 4), number(at + 24, 4), layers == 0 ? 1 : layers, number(at + 40, 4));
}

static void read_package(void)
{
    uint64_t count, end, k;
    uint32_t crc;
    if (file_length < 12 || memcmp(file, "\x89PELAGE\n", 8) != 0)
        fail("not a pelage package", 0);
    version = number(8, 4);
    if (version < 1 || version > 3)
        fail("not version 1 to 3", 8);
    count = number(12, 4);
    end = 32 + 32 * count;
    if (end > file_length)
        fail("the file ends inside the section table", 32);
    crc = crc_update(UINT32_C(0xffffffff), file, 24);
    crc = ~crc_update(crc, file + 28, end - 28);
    if (number(24, 4) != crc)
        fail("the head checksum is wrong", 24);
    expect_zero(28, 32);
    printf("version %" PRIu64 " sections %" PRIu64 " bytes %" PRIu64 "\n", version, count, number(16, 8));
    for (k = 0; k < count; k++) {
        uint64_t entry = 32 + 32 * k, offset = number(entry + 8, 8), length = number(entry + 16, 8);
        struct cursor c;
        expect_zero(entry + 4, entry + 8);
        expect_zero(entry + 28, entry + 32);
        if (offset != align(end) || offset > file_length || length > file_length - offset)
            fail("a section does not lie where it must", entry + 8);
        expect_zero(end, offset);
        if (number(entry + 24, 4) != (uint32_t)~crc_update(UINT32_C(0xffffffff), file + offset, length))
            fail("a section is damaged", offset);
        end = offset + length;
        printf("section %.4s offset %" PRIu64 " length %" PRIu64 "\n", (const char *)file + entry, offset, length);
        c.at = offset;
        c.end = end;
        if ((k == 0) != (memcmp(file + entry, "MANI", 4) == 0))
            fail("expected one manifest, at the front", entry);
        if (k == 0)
            read_manifest(c);
        if (memcmp(file + entry, "MESH", 4) == 0)
            read_mesh(offset, length);
        if (version > 1 && memcmp(file + entry, "FINS", 4) == 0)
            read_fins(offset, length);
        if (memcmp(file + entry, "KTX2", 4) == 0)
            read_texture(offset, length);
    }
    for (k = 0; k < fin_count; k++)
        if (number(first_fin + 24 * k, 4) >= vertex_count || number(first_fin + 24 * k + 4, 4) >= vertex_count)
            fail("a fin stands on a vertex that is not there", first_fin + 24 * k);
    expect_zero(end, align(end));
    if (align(end) != file_length || number(16, 8) != file_length)
        fail("the file does not end where it must", end);
}

int main(int argc, char **argv)
{
    FILE *stream = argc == 2 ? fopen(argv[1], "rb") : NULL;
    uint8_t *bytes;
    long length;
    if (stream == NULL || fseek(stream, 0, SEEK_END) != 0 || (length = ftell(stream)) < 0) {
        fprintf(stderr, "usage: read_pelage FILE, a readable package\n");
        return 2;
    }
    rewind(stream);
    bytes = malloc((size_t)length + 1);
    if (bytes == NULL || fread(bytes, 1, (size_t)length, stream) != (size_t)length)
        return 2;
    file = bytes;
    file_length = (uint64_t)length;
    read_package();
    return 0;
}
