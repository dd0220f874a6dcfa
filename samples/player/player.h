/* A player for the step tables of beamcam, for a micro-controller: standard C, no library.
 *
 * It writes the words of two motors and the laser to a port when the table says so. It begins
 * only in the shielded corner, with the door closed. A door that opens in the middle puts the
 * laser out at once and brings the head to rest along its path by slowing the table's own clock,
 * so that no step is lost. On resume the head runs back along the path, turns, and has its full
 * speed again where the laser went out. A ramp of the clock adds speed / PLAYER_RAMP_US to the
 * acceleration of the table (0.32 m/s2 at 80 mm/s): the motors need that much in hand.
 *
 * docs/step-tables.md describes the tables. Call player_tick() at player_due(), from a timer.
 */
#ifndef PLAYER_H
#define PLAYER_H

#include <stdint.h>

#define PLAYER_LASER 0x10u   /* bit of the laser in a row and on the port */
#define PLAYER_RAMP_US 250000 /* from full speed of the table's clock to rest; at most 2 s */
#define PLAYER_SLICE_US 100  /* while the clock ramps, the least often that player_tick() is due */
#define PLAYER_NEVER UINT64_MAX

enum player_state {
    PLAYER_READY,    /* in its first row, laser off, waits for player_start() */
    PLAYER_RUNNING,  /* along the table, at full speed or on the way to it */
    PLAYER_STOPPING, /* the door was opened: laser off, slowing down */
    PLAYER_PAUSED,   /* at rest, waits for player_resume() */
    PLAYER_BACKING,  /* resumed: back along the path for a run-up */
    PLAYER_DONE,     /* in its last row, laser off, in the corner */
    PLAYER_FAULT     /* laser off, motors hold; player_init() begins anew */
};

enum player_fault {
    PLAYER_NO_FAULT,
    PLAYER_BAD_TABLE,     /* no table, or one whose words skip, or that ends elsewhere */
    PLAYER_NOT_IN_CORNER, /* at start: the corner's switch is open, the laser stays off */
    PLAYER_DOOR_OPEN,     /* at start or resume */
    PLAYER_LOST_STEPS     /* at the end: the table is through, the corner's switch is open */
};

/* The rows, wherever they lie: the array of a .h, or a .bin behind its header. */
struct player_table {
    const void *rows;
    uint32_t (*row)(const void *rows, uint32_t index);
    uint32_t count;
    uint8_t words[4]; /* the sequence that a motor turns forwards by */
};

/* What the board gives. The switches are asked at every tick. */
struct player_port {
    void *board;
    void (*write)(void *board, uint8_t bits); /* bits 0-1 word of X, 2-3 word of Y, 4 laser */
    int (*door_is_open)(void *board);
    int (*is_in_corner)(void *board);
};

struct player {
    struct player_table table;
    struct player_port port;
    enum player_state state;
    enum player_fault fault;
    uint32_t index;    /* row that the motors stand in */
    uint64_t row_us;   /* time of that row in the table */
    uint64_t clock_q;  /* where the table's clock stands, in 1/65536 us */
    int32_t rate;      /* of the table's clock against time, 65536 is full speed */
    int32_t rest;      /* of the division that changes the rate */
    uint64_t cut_us;   /* time of the table to which the laser has done its work */
    uint64_t now_us;   /* of the last tick */
    uint8_t bits;      /* on the port */
};

/* The rows of a .bin file of `size` bytes. Gives 0 if its header is none. */
int player_table_of_bytes(struct player_table *table, const uint8_t *bytes, uint32_t size);
/* The rows of a .h: beamcam_steps, BEAMCAM_STEPS, and the sequence 00 01 10 11 or another. */
void player_table_of_array(struct player_table *table, const uint32_t *rows, uint32_t count,
                           const uint8_t words[4]);

/* Checks the whole table and puts the port in its rest position. */
enum player_fault player_init(struct player *p, const struct player_table *table,
                              const struct player_port *port);
enum player_fault player_start(struct player *p, uint64_t now_us);
enum player_fault player_resume(struct player *p, uint64_t now_us);
/* Does what is due, and asks the door's switch. */
void player_tick(struct player *p, uint64_t now_us);
/* When the next row is due, or a slice of a ramp; PLAYER_NEVER if nothing moves. */
uint64_t player_due(const struct player *p);

#endif
