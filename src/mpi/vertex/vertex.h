/* vertex.h: what ranks do together, and vertex normals of a mesh whose parts lie on them. */
#ifndef NORMA_MPI_VERTEX_H
#define NORMA_MPI_VERTEX_H
#include "core/call/call.h"
#include "core/corner/corner.h"
#include "core/mesh/mesh.h"
#include "core/vertex/vertex.h"
#include <mpi.h>

/* ---- What all ranks do together: agreeing on a result, and handing records to each other. */

/* What is sent: positions of a file to the ranks that name them; positions to their homes, and
 * answers; votes; normals, and questions for them; tables of cells; all else. */
typedef enum mpi_cargo {
    MPI_POSITIONS,
    MPI_KEYS,
    MPI_CONTRIBUTIONS,
    MPI_NORMALS,
    MPI_CELLS,
    MPI_OTHERS,
    MPI_CARGOS
} mpi_cargo;

typedef struct mpi_call {
    MPI_Comm comm; /* a copy of the caller's: messages of others never meet ours */
    int rank, ranks;
    core_call *core; /* memory, progress, options */
    /* Bytes that left this rank for others; what ranks agree on is left out. */
    uint64_t sent[MPI_CARGOS];
} mpi_call;

/* Collective. comm: the caller's. End frees the copy. */
norma_result norma_mpi_begin(mpi_call *call, MPI_Comm comm, core_call *core);
void norma_mpi_end(mpi_call *call);

/* Collective: all ranks' numbers become one, in place. */
void norma_mpi_reduce(const mpi_call *call, void *all, int count, MPI_Datatype type, MPI_Op op);
/* Collective: the gravest of all ranks' results, on every rank. */
norma_result norma_mpi_agree(const mpi_call *call, norma_result mine);
/* The same, and each rank's progress is told: one that cancels cancels all. */
norma_result norma_mpi_step(mpi_call *call, double fraction, norma_result mine);

/* Collective sums, and the largest and the least, over all ranks. */
uint64_t norma_mpi_sum(const mpi_call *call, uint64_t mine);
uint64_t norma_mpi_largest(const mpi_call *call, uint64_t mine);
uint64_t norma_mpi_least(const mpi_call *call, uint64_t mine);
/* Collective: of the ranks before this one; 0 for the first. */
uint64_t norma_mpi_sum_before(const mpi_call *call, uint64_t mine);
uint64_t norma_mpi_largest_before(const mpi_call *call, uint64_t mine);
/* Collective: whether count numbers are the same everywhere. */
int norma_mpi_all_equal(const mpi_call *call, const uint64_t *numbers, size_t count);

/* Records of one size for each rank. */
typedef struct mpi_lists {
    unsigned char *bytes;
    size_t capacity, record; /* bytes of all, and of one */
    int *counts, *starts;    /* of each rank, in records; starts has the end as well */
} mpi_lists;

/* room: records for each rank at most. OVERFLOW where all together are too many for a message. On
 * an error there is nothing to close. */
norma_result norma_mpi_lists_open(
    const mpi_call *call, const uint64_t *room, size_t record, mpi_lists *lists);
void norma_mpi_lists_close(const mpi_call *call, mpi_lists *lists);
static inline unsigned char *norma_mpi_record(const mpi_lists *lists, size_t index) {
    return lists->bytes + index * lists->record;
}
/* The next one for a rank. */
static inline unsigned char *norma_mpi_lists_add(mpi_lists *lists, int rank) {
    return norma_mpi_record(lists, (size_t)lists->starts[rank] + (size_t)lists->counts[rank]++);
}
static inline size_t norma_mpi_lists_total(const mpi_call *call, const mpi_lists *lists) {
    size_t sum = 0;
    for (int r = 0; r < call->ranks; ++r) sum += (size_t)lists->counts[r];
    return sum;
}

/* Which of count things go to which ranks, and what is told of each. */
typedef struct mpi_listing {
    size_t count, record;
    int (*rank_of)(const void *context, size_t i); /* -1: to none */
    void (*write)(const void *context, size_t i, unsigned char *record);
    const void *context;
} mpi_listing;
/* Opens the lists of those, in their order. On an error there is nothing to close. */
norma_result norma_mpi_list(const mpi_call *call, const mpi_listing *listing, mpi_lists *lists);

/* Collective: opens in, and fills it with what the ranks have for this one, in the order of ranks.
 * mine: the result so far, agreed on first. On an error in is closed. */
norma_result norma_mpi_exchange(
    mpi_call *call, mpi_cargo cargo, norma_result mine, const mpi_lists *out, mpi_lists *in);

/* Fills answers, a record for each of those in in. */
typedef norma_result mpi_answer(void *context, const mpi_lists *in, mpi_lists *answers);
/* Collective: a record of that size for each thing that is listed, from the rank that it went to,
 * in the order of the lists of those. On an error there is nothing to close. */
norma_result norma_mpi_ask(mpi_call *call, mpi_cargo cargo, const mpi_listing *listing,
    size_t record, mpi_answer *answer, void *context, mpi_lists *back);

/* ---- norma_mpi_vertex_normals; and, if sent is not NULL, what this rank sent (mpi_cargo) is added
 * there. */
norma_result norma_mpi_normals_of(MPI_Comm comm, uint64_t *sent, const norma_mesh *part,
    const uint64_t *vertex_ids, const uint64_t *face_ids, const norma_options *options,
    float *normals, size_t capacity, norma_report *report);

/* ---- The faces of a part in ascending global number. */

typedef struct mpi_face_order {
    const uint64_t *ids; /* of each face, or NULL: they follow one another from first on */
    uint64_t first;
    uint32_t *order; /* NULL: they ascend as they are */
    size_t count;
} mpi_face_order;

/* MEMORY leaves nothing to close. */
norma_result norma_mpi_order_faces(
    const core_call *call, const uint64_t *ids, size_t count, mpi_face_order *order);
void norma_mpi_order_close(const core_call *call, mpi_face_order *order);

static inline size_t norma_mpi_face(const mpi_face_order *order, size_t i) {
    return order->order ? order->order[i] : i;
}
static inline uint64_t norma_mpi_face_id(const mpi_face_order *order, size_t face) {
    return order->ids ? order->ids[face] : order->first + face;
}

/* ---- This rank's part of the mesh, checked and agreed upon, ready to be summed. */

typedef struct mpi_input {
    const norma_mesh *mesh;
    const uint64_t *vertex_ids, *face_ids;
    float *normals;
    size_t capacity;
} mpi_input;

typedef struct mpi_part {
    core_prepared_mesh prepared;
    int is_prepared;
    core_output output;
    const uint64_t *vertex_ids;
    mpi_face_order faces;
    int numbered; /* ranks' faces mix, so votes carry their numbers */
    int doubles;  /* some rank's positions are doubles */
    uint64_t
        *groups;   /* with NORMA_WELD_DISTANCE: of each position, the same for those that are one */
    size_t budget; /* bytes for lists */
    size_t positions;
} mpi_part;

/* Collective. core: begun by begun, which is agreed upon here. On an error there is nothing to
 * close. */
norma_result norma_mpi_open_part(
    mpi_call *call, norma_result begun, const mpi_input *input, mpi_part *part);
/* *weld: for each of count numbers the first that is equal; NULL where all differ. */
norma_result norma_mpi_weld_numbers(
    core_call *core, const uint64_t *numbers, size_t count, uint32_t **weld);
void norma_mpi_close_part(const mpi_call *call, mpi_part *part);

/* ---- Which positions other ranks have as well, and where the sum of each is taken. */

/* What makes two positions one: where they are, or a number. */
typedef struct mpi_keys {
    const core_mesh *mesh;   /* positions */
    const uint64_t *numbers; /* instead, if not NULL */
    int doubles;             /* some rank's positions are doubles */
} mpi_keys;

/* A rank's part in a position. */
enum { MPI_ABSENT = 0, MPI_LISTENS, MPI_VOTES };

/* Where the sum of a position is: at this rank, alone or also waited for by others; at its home,
 * which wants each contribution; at its home, which wants nothing from here. */
typedef enum mpi_kind { MPI_OWN = 0, MPI_SHARED, MPI_ASKED, MPI_NOWHERE } mpi_kind;
typedef uint64_t mpi_place; /* 48 bits: the kind, the home, the slot; or the kind and a sum here */
enum { MPI_KIND_AT = 46, MPI_HOME_AT = 28, MPI_MOST_RANKS = 1 << (MPI_KIND_AT - MPI_HOME_AT) };
static inline mpi_place norma_mpi_place(mpi_kind kind, int home, uint64_t slot) {
    return (uint64_t)kind << MPI_KIND_AT | (uint64_t)home << MPI_HOME_AT | slot;
}
static inline mpi_kind norma_mpi_kind(mpi_place place) { return (mpi_kind)(place >> MPI_KIND_AT); }
static inline int norma_mpi_home(mpi_place place) {
    return (int)(place >> MPI_HOME_AT & (MPI_MOST_RANKS - 1));
}
static inline uint64_t norma_mpi_slot(mpi_place place) {
    const int bits = norma_mpi_kind(place) == MPI_OWN ? MPI_KIND_AT : MPI_HOME_AT;
    return place & ((UINT64_C(1) << bits) - 1);
}

/* A place as it is kept for each position, of which a part in random order has nearly three for
 * each of its triangles. */
typedef struct mpi_kept_place {
    uint16_t parts[3];
} mpi_kept_place;
static inline mpi_kept_place norma_mpi_keep_place(mpi_place place) {
    return (mpi_kept_place){{(uint16_t)place, (uint16_t)(place >> 16), (uint16_t)(place >> 32)}};
}

/* A sum that is taken here, for which its home waits. */
typedef struct mpi_loan {
    mpi_place place;
    uint64_t sum;
} mpi_loan;

typedef struct mpi_sharing {
    size_t count;
    mpi_kept_place *places; /* of each position; slots of MPI_OWN are sums here, of which the first
                               stays empty */
    mpi_loan *loans;
    size_t loan_count, loan_room;
    uint64_t own;    /* sums that are taken here */
    uint64_t *slots; /* of each rank: how many it is the home of */
} mpi_sharing;

static inline mpi_place norma_mpi_place_at(const mpi_sharing *sharing, size_t v) {
    const uint16_t *parts = sharing->places[v].parts;
    return (uint64_t)parts[2] << 32 | (uint64_t)parts[1] << 16 | parts[0];
}

/* Collective. part: of each position. lend: a position of which one rank has all votes is summed
 * there. budget: bytes that lists may take. On an error there is nothing to close. */
norma_result norma_mpi_share(mpi_call *call, const mpi_keys *keys, const uint8_t *part, int lend,
    size_t budget, mpi_sharing *sharing);
void norma_mpi_sharing_close(const mpi_call *call, mpi_sharing *sharing);

/* The home of a number. */
int norma_mpi_home_of_number(const mpi_call *call, uint64_t number);

/* ---- The sum at each position, each in ascending number of faces, wherever they are. */

/* What became of a slot. */
typedef struct mpi_outcome {
    float normal[3];
    uint32_t reason; /* UNREFERENCED where nobody votes */
} mpi_outcome;

typedef struct mpi_sums {
    const core_prepared_mesh *prepared;
    const mpi_face_order *faces;
    const uint32_t *merge; /* NULL, or for each position the one that stands for it in sharing */
    const mpi_sharing *sharing;
    int numbered;            /* contributions carry the numbers of their faces */
    norma_count *degenerate; /* NULL: they are not counted */
    core_vertex_sum *own;    /* of the sums that are taken here */
    mpi_outcome *outcomes;   /* of the slots of this rank */
} mpi_sums;

/* Collective. The caller sets all but own and outcomes. On an error there is nothing to close. */
norma_result norma_mpi_sum_all(mpi_call *call, size_t budget, mpi_sums *sums);
void norma_mpi_sums_close(const mpi_call *call, mpi_sums *sums);

/* Collective: what became of each position that takes part, in sharing's terms, some at a time.
 * reason: UNREFERENCED also where the position is not finite. */
typedef void mpi_receiver(void *context, size_t position, int reason, const float normal[3]);
norma_result norma_mpi_hand_out(
    mpi_call *call, const mpi_sums *sums, size_t budget, mpi_receiver *receive, void *context);

/* ---- The vertices that have no normal of their own: counted, and given that of the nearest
 * one that has. */

/* Collective: the tallies of all ranks, added up. */
void norma_mpi_add_tallies(const mpi_call *call, core_tally *tally);

/* Collective: writes to each position with a reason the normal of the nearest position without one,
 * which it reads from the output; zero where there is none anywhere. */
norma_result norma_mpi_fill_nearest(mpi_call *call, const mpi_part *part, const uint8_t *reasons);
#endif
