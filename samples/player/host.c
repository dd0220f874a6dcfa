/* The player on a PC: a simulated board that prints each write to its port with its time.
 *
 *     gcc -std=c99 -o play host.c player.c                         plays a .bin
 *     gcc -std=c99 -DTABLE='"job.h"' -o play host.c player.c       plays the .h that is built in
 *
 *     ./play job.bin                      lines: microseconds, word of X, word of Y, laser
 *     ./play job.bin 2000000:3500000      the door opened at 2 s, closed and resumed at 3.5 s
 *     ./play job.bin --not-in-corner      the corner's switch stays open
 *     ./play job.bin --lost               the corner's switch is open at the end
 *
 * A board of one's own has the same three functions, and calls player_tick() from its timer.
 */
#include <stdio.h>
#include <string.h>

#include "player.h"

#ifdef TABLE
#include TABLE
#endif

#define MAX_BYTES (64u << 20)

struct board {
    uint64_t now_us;
    uint64_t opens_us, closes_us; /* the door; PLAYER_NEVER if it stays closed */
    int in_corner;
};

static void write_port(void *at, uint8_t bits)
{
    const struct board *board = at;

    printf("%llu,%u%u,%u%u,%u\n", (unsigned long long)board->now_us, bits >> 1 & 1u, bits & 1u,
           bits >> 3 & 1u, bits >> 2 & 1u, bits >> 4 & 1u);
}

static int door_is_open(void *at)
{
    const struct board *board = at;

    return board->now_us >= board->opens_us && board->now_us < board->closes_us;
}

static int is_in_corner(void *at) { return ((const struct board *)at)->in_corner; }

static int stop(const char *why)
{
    fprintf(stderr, "%s\n", why);
    return 1;
}

static const char *name_of(enum player_fault fault)
{
    static const char *names[] = {"no fault", "bad table", "not in corner", "door open",
                                  "lost steps"};
    return names[fault];
}

/* To the next of what is due, or that the door does. */
static void play(struct player *p, struct board *board, uint64_t opens_us, uint64_t closes_us)
{
    for (;;) {
        uint64_t due = player_due(p);

        if (board->now_us < opens_us && opens_us < due)
            due = opens_us;
        if (due == PLAYER_NEVER && p->state == PLAYER_PAUSED)
            due = closes_us > board->now_us ? closes_us : board->now_us;
        if (due == PLAYER_NEVER)
            return;
        board->now_us = due;
        player_tick(p, due);
        if (p->state == PLAYER_PAUSED && due >= closes_us)
            player_resume(p, due);
    }
}

int main(int argc, char **argv)
{
    static struct player p;
    struct player_table table;
    struct board board = {0, PLAYER_NEVER, PLAYER_NEVER, 1};
    struct player_port port;
    enum player_fault fault;
    unsigned long long opens = 0, closes = 0;
    int k, lost = 0, doors = 0;
#ifdef TABLE
    static const uint8_t words[4] = {0, 1, 2, 3};

    player_table_of_array(&table, beamcam_steps, BEAMCAM_STEPS, words);
    k = 1;
#else
    static uint8_t bytes[MAX_BYTES];
    FILE *file = argc > 1 ? fopen(argv[1], "rb") : NULL;
    size_t size;

    if (file == NULL)
        return stop("no table");
    size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    if (size == sizeof bytes || !player_table_of_bytes(&table, bytes, (uint32_t)size))
        return stop("bad table");
    k = 2;
#endif
    for (; k < argc; k++) {
        if (strcmp(argv[k], "--not-in-corner") == 0)
            board.in_corner = 0;
        else if (strcmp(argv[k], "--lost") == 0)
            lost = 1;
        else if (sscanf(argv[k], "%llu:%llu", &opens, &closes) == 2 && opens < closes)
            doors = 1;
        else
            return stop("expected OPENS_US:CLOSES_US, --not-in-corner or --lost");
    }
    if (doors) {
        board.opens_us = opens;
        board.closes_us = closes;
    }
    port.board = &board;
    port.write = write_port;
    port.door_is_open = door_is_open;
    port.is_in_corner = is_in_corner;
    fault = player_init(&p, &table, &port);
    if (fault == PLAYER_NO_FAULT)
        fault = player_start(&p, 0);
    if (fault != PLAYER_NO_FAULT)
        return stop(name_of(fault));
    if (lost)
        board.in_corner = 0;
    play(&p, &board, board.opens_us, board.closes_us);
    return p.state == PLAYER_DONE ? 0 : stop(name_of(p.fault));
}
