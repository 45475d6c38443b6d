#include "core/geom/parting.h"

#include "core/base/union.h"

/* Times that groups may grow at a level. Points of shell60k in a wrong group, at 5 / 8 / 12: 646 /
 * 401 / 401; without levels 700. */
enum { GROWTH = 8 };

/* An entry of a group's list of those that it was parted from. */
struct parted {
    uint32_t node; /* of the other group */
    uint32_t next; /* entry; NONE: the last */
};

#define NONE UINT32_MAX

struct parting {
    uint32_t *group;              /* n: way to the group's first node */
    uint32_t *first, *last, *has; /* of the group whose first node this is: entries, how many */
    uint32_t *size;               /* nodes of it */
    size_t most;                  /* nodes that a group may have */
    struct parted *parted;
    uint32_t count;         /* of entries */
    struct vor_bond *spare; /* as many as bonds */
};

/* What bonds are sorted by. */
enum by { FIRST, SECOND, STRENGTH, STRONGEST };

static uint32_t key_of(const struct vor_bond *bond, enum by by)
{
    union {
        float strength;
        uint32_t bits;
    } to = {bond->strength};

    if (by == STRENGTH)
        return to.bits ^ (to.bits >> 31 ? UINT32_MAX : UINT32_C(1) << 31);
    return by == FIRST ? bond->a : by == SECOND ? bond->b : ~(to.bits << 1);
}

/* Sorts bonds, and leaves those with equal keys in their order: by counting, eight bits at a time.
 */
static void sort(const struct parting *parting, struct vor_bond *bond, size_t count, enum by by)
{
    struct vor_bond *from = bond, *to = parting->spare, *other;

    for (unsigned shift = 0; shift < 32; shift += 8, other = from, from = to, to = other) {
        size_t at[256] = {0}, before = 0;

        for (size_t e = 0; e < count; e++)
            at[key_of(&from[e], by) >> shift & 255]++;
        for (size_t k = 0; k < 256; k++) {
            before += at[k];
            at[k] = before - at[k];
        }
        for (size_t e = 0; e < count; e++)
            to[at[key_of(&from[e], by) >> shift & 255]++] = from[e];
    }
}

static uint32_t find(struct parting *parting, uint32_t i)
{
    return vor_union_root(parting->group, i);
}

/* Whether groups a and b were parted. Looks through the shorter list; what it finds comes first
 * there, as the same two are asked about again and again. */
static int are_parted(struct parting *parting, uint32_t a, uint32_t b)
{
    uint32_t of = parting->has[a] <= parting->has[b] ? a : b, other = of == a ? b : a;
    uint32_t before = NONE;

    for (uint32_t e = parting->first[of]; e != NONE; before = e, e = parting->parted[e].next) {
        struct parted *here = &parting->parted[e];

        if (find(parting, here->node) != other)
            continue;
        if (before != NONE) {
            parting->parted[before].next = here->next;
            if (parting->last[of] == e)
                parting->last[of] = before;
            here->next = parting->first[of];
            parting->first[of] = e;
        }
        return 1;
    }
    return 0;
}

static void add_parted(struct parting *parting, uint32_t a, uint32_t b)
{
    uint32_t e = parting->count++;

    parting->parted[e] = (struct parted){b, parting->first[a]};
    parting->first[a] = e;
    if (parting->has[a]++ == 0)
        parting->last[a] = e;
}

/* Makes one group of a and b. */
static void join(struct parting *parting, uint32_t a, uint32_t b)
{
    uint32_t to = a < b ? a : b, from = a < b ? b : a;

    parting->group[from] = to;
    parting->size[to] += parting->size[from];
    if (parting->has[from] == 0)
        return;
    if (parting->has[to] == 0)
        parting->first[to] = parting->first[from];
    else
        parting->parted[parting->last[to]].next = parting->first[from];
    parting->last[to] = parting->last[from];
    parting->has[to] += parting->has[from];
}

static void take(struct parting *parting, const struct vor_bond *bond)
{
    uint32_t a = find(parting, bond->a), b = find(parting, bond->b);

    if (a == b || are_parted(parting, a, b))
        return;
    if (bond->strength > 0) {
        if ((size_t)parting->size[a] + parting->size[b] <= parting->most)
            join(parting, a, b);
    } else {
        add_parted(parting, a, b);
        add_parted(parting, b, a);
    }
}

/* Makes bonds between nodes into those between their groups, of the sum of their strengths. Returns
 * how many are left. */
static size_t gather(struct parting *parting, struct vor_bond *bond, size_t count)
{
    size_t left = 0, kept = 0;

    for (size_t e = 0; e < count; e++) {
        uint32_t a = find(parting, bond[e].a), b = find(parting, bond[e].b);

        if (a != b)
            bond[left++] = (struct vor_bond){a < b ? a : b, a < b ? b : a, bond[e].strength};
    }
    sort(parting, bond, left, STRENGTH); /* sums are in one order */
    sort(parting, bond, left, SECOND);
    sort(parting, bond, left, FIRST);
    for (size_t e = 0; e < left; kept++) {
        struct vor_bond sum = bond[e++];

        while (e < left && bond[e].a == sum.a && bond[e].b == sum.b)
            sum.strength += bond[e++].strength;
        bond[kept] = sum;
    }
    return kept;
}

/* Finds the groups, level by level. */
static vor_status part(struct parting *parting, size_t n, struct vor_bond *bond, size_t count,
                       const struct vor_run *run, struct vor_error *err)
{
    vor_status status = VOR_OK;

    for (uint32_t i = 0; i < n; i++) {
        parting->group[i] = i;
        parting->size[i] = 1;
    }
    for (size_t most = 1; most < n && status == VOR_OK;) {
        most *= GROWTH;
        count = gather(parting, bond, count);
        parting->most = most;
        parting->count = 0;
        for (uint32_t i = 0; i < n; i++) {
            parting->first[i] = NONE;
            parting->has[i] = 0;
        }
        sort(parting, bond, count, STRONGEST); /* they came by their nodes */
        for (size_t e = 0; e < count; e++)
            take(parting, &bond[e]);
        status = vor_run_answered(vor_run_poll(run), err);
    }
    for (uint32_t i = 0; i < n; i++)
        parting->group[i] = find(parting, i);
    return status;
}

vor_status vor_parting_make(uint32_t *group, size_t n, struct vor_bond *bond, size_t count,
                            const struct vor_run *run, struct vor_error *err)
{
    struct vor_memory *memory = run->memory;
    struct parting parting = {.group = group};
    vor_status status = VOR_OK;
    size_t parts = 0; /* groups' pairs that part are sums of at least one of these each */

    for (size_t e = 0; e < count; e++)
        parts += bond[e].strength < 0;
    parting.first = vor_malloc(memory, n, sizeof *parting.first);
    parting.last = vor_malloc(memory, n, sizeof *parting.last);
    parting.has = vor_malloc(memory, n, sizeof *parting.has);
    parting.size = vor_malloc(memory, n, sizeof *parting.size);
    parting.parted = vor_malloc(memory, parts, 2 * sizeof *parting.parted);
    parting.spare = vor_malloc(memory, count, sizeof *parting.spare);
    if (parting.spare == NULL || parting.first == NULL || parting.last == NULL ||
        parting.has == NULL || parting.size == NULL || parting.parted == NULL ||
        parts >= UINT32_MAX / 2)
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    else
        status = part(&parting, n, bond, count, run, err);
    VOR_FREE_ALL(memory, parting.spare, parting.parted, parting.size, parting.has, parting.last,
                 parting.first);
    return status;
}
