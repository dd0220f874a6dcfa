#include "player.h"

#define FULL 65536
#define MAGIC "BCSTEPS1"
#define HEADER 32u

static uint32_t wait_us(uint32_t row) { return row >> 5; }
static uint8_t bits_of(uint32_t row) { return (uint8_t)(row & 0x1fu); }

static uint32_t little_endian(const uint8_t *at)
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

static uint32_t row_of_bytes(const void *rows, uint32_t index)
{
    return little_endian((const uint8_t *)rows + 4u * index);
}

static uint32_t row_of_array(const void *rows, uint32_t index)
{
    return ((const uint32_t *)rows)[index];
}

int player_table_of_bytes(struct player_table *table, const uint8_t *bytes, uint32_t size)
{
    static const char magic[] = MAGIC;
    uint32_t k;

    if (size < HEADER || (size - HEADER) % 4u != 0 || little_endian(bytes + 8) != HEADER)
        return 0;
    for (k = 0; k < 8; k++)
        if (bytes[k] != (uint8_t)magic[k])
            return 0;
    for (k = 0; k < 4; k++)
        table->words[k] = (uint8_t)little_endian(bytes + 16 + 4 * k);
    table->rows = bytes + HEADER;
    table->row = row_of_bytes;
    table->count = (size - HEADER) / 4u;
    return 1;
}

void player_table_of_array(struct player_table *table, const uint32_t *rows, uint32_t count,
                           const uint8_t words[4])
{
    int k;

    for (k = 0; k < 4; k++)
        table->words[k] = words[k];
    table->rows = rows;
    table->row = row_of_array;
    table->count = count;
}

/* Which place of the sequence a word has; -1 for none. */
static int place_of(const struct player_table *table, uint8_t word)
{
    int k;

    for (k = 0; k < 4; k++)
        if (table->words[k] == word)
            return k;
    return -1;
}

/* -1, 0 or 1 step from one word to the next; 2 if the motor would skip. */
static int step_between(const struct player_table *table, uint8_t from, uint8_t to)
{
    static const int steps[4] = {0, 1, 2, -1};

    return steps[(place_of(table, to) - place_of(table, from)) & 3];
}

static int is_sound(const struct player_table *table)
{
    uint8_t rest, last;
    uint32_t k;
    int i, j;
    long x = 0, y = 0;

    for (i = 0; i < 4; i++)
        for (j = 0; j < i; j++)
            if (table->words[i] > 3 || table->words[j] > 3 || table->words[i] == table->words[j])
                return 0;
    if (table->count < 2)
        return 0;
    rest = (uint8_t)(table->words[0] | table->words[0] << 2);
    last = bits_of(table->row(table->rows, 0));
    if (last != rest || wait_us(table->row(table->rows, 0)) != 0)
        return 0;
    for (k = 1; k < table->count; k++) {
        uint8_t bits = bits_of(table->row(table->rows, k));
        int dx = step_between(table, last & 3u, bits & 3u);
        int dy = step_between(table, last >> 2 & 3u, bits >> 2 & 3u);

        if (dx == 2 || dy == 2)
            return 0;
        x += dx;
        y += dy;
        last = bits;
    }
    return last == rest && x == 0 && y == 0;
}

static uint64_t clock_us(const struct player *p) { return p->clock_q >> 16; }

/* The laser burns only where it has not yet, at full speed; so a pause leaves no mark. */
static int may_burn(const struct player *p)
{
    return p->state == PLAYER_RUNNING && p->rate == FULL && clock_us(p) >= p->cut_us;
}

static void put(struct player *p)
{
    uint8_t bits = bits_of(p->table.row(p->table.rows, p->index));

    if (!may_burn(p))
        bits &= (uint8_t)~PLAYER_LASER;
    if (bits != p->bits)
        p->port.write(p->port.board, p->bits = bits);
}

static enum player_fault fail(struct player *p, enum player_fault fault)
{
    p->state = PLAYER_FAULT;
    p->fault = fault;
    if (p->bits & PLAYER_LASER)
        p->port.write(p->port.board, p->bits &= (uint8_t)~PLAYER_LASER);
    return fault;
}

enum player_fault player_init(struct player *p, const struct player_table *table,
                              const struct player_port *port)
{
    p->table = *table;
    p->port = *port;
    p->state = PLAYER_READY;
    p->fault = PLAYER_NO_FAULT;
    p->index = 0;
    p->row_us = p->clock_q = p->cut_us = p->now_us = 0;
    p->rate = p->rest = 0;
    p->bits = (uint8_t)((table->words[0] | table->words[0] << 2) & 0xfu);
    port->write(port->board, p->bits);
    return is_sound(table) ? PLAYER_NO_FAULT : fail(p, PLAYER_BAD_TABLE);
}

enum player_fault player_start(struct player *p, uint64_t now_us)
{
    if (p->state != PLAYER_READY)
        return p->fault;
    if (p->port.door_is_open(p->port.board))
        return PLAYER_DOOR_OPEN;
    if (!p->port.is_in_corner(p->port.board))
        return PLAYER_NOT_IN_CORNER;
    p->state = PLAYER_RUNNING; /* the head rests, so that the clock needs no ramp */
    p->rate = FULL;
    p->now_us = now_us;
    return PLAYER_NO_FAULT;
}

enum player_fault player_resume(struct player *p, uint64_t now_us)
{
    if (p->state != PLAYER_PAUSED)
        return p->fault;
    if (p->port.door_is_open(p->port.board))
        return PLAYER_DOOR_OPEN;
    p->state = PLAYER_BACKING;
    p->now_us = now_us;
    return PLAYER_NO_FAULT;
}

/* Where the run-up begins: a ramp takes half its time of the table, and a little is spare. */
static uint64_t turn_us(const struct player *p)
{
    uint64_t run_up = PLAYER_RAMP_US / 2 + 10 * PLAYER_SLICE_US;

    return p->cut_us > run_up ? p->cut_us - run_up : 0;
}

/* The rate that the state asks for. */
static int32_t rate_wanted(const struct player *p)
{
    if (p->state == PLAYER_RUNNING)
        return FULL;
    if (p->state == PLAYER_BACKING) {
        /* rate^2 ramp / 2 is the way to rest, in us of the table */
        uint64_t way = (uint64_t)((int64_t)p->rate * p->rate / FULL * PLAYER_RAMP_US / FULL / 2);

        return clock_us(p) > turn_us(p) + way ? -FULL : 0;
    }
    return 0;
}

static void change_rate(struct player *p, uint32_t elapsed_us)
{
    int32_t wanted = rate_wanted(p);
    int64_t scaled = (int64_t)elapsed_us * FULL + p->rest;
    int32_t most = (int32_t)(scaled / PLAYER_RAMP_US);

    if (p->rate == wanted) {
        p->rest = 0;
        return;
    }
    p->rest = (int32_t)(scaled % PLAYER_RAMP_US);
    if (p->rate < wanted)
        p->rate = wanted - p->rate > most ? p->rate + most : wanted;
    else
        p->rate = p->rate - wanted > most ? p->rate - most : wanted;
    if (p->rate == FULL) /* from here on rows come at whole microseconds */
        p->clock_q &= ~(uint64_t)(FULL - 1);
}

static void advance(struct player *p, uint32_t elapsed_us)
{
    int64_t way = (int64_t)elapsed_us * p->rate;

    if (way < 0 && p->clock_q < (uint64_t)-way)
        p->clock_q = 0;
    else
        p->clock_q += (uint64_t)way;
}

/* To the row that the clock stands in, one step at a time in either direction. */
static void follow(struct player *p)
{
    while (p->index + 1 < p->table.count) {
        uint64_t next = p->row_us + wait_us(p->table.row(p->table.rows, p->index + 1));

        if (next > clock_us(p))
            break;
        p->index++;
        p->row_us = next;
        put(p);
    }
    while (p->index > 0 && p->row_us > clock_us(p)) {
        p->row_us -= wait_us(p->table.row(p->table.rows, p->index));
        p->index--;
        put(p);
    }
}

/* Whether the head has come back to where its run-up begins. */
static int is_back(const struct player *p)
{
    uint64_t turn = turn_us(p);

    return turn == 0 ? p->clock_q == 0 : p->rate == 0 && clock_us(p) <= turn + PLAYER_SLICE_US;
}

static void end_phase(struct player *p)
{
    if (p->state == PLAYER_STOPPING && p->rate == 0) {
        p->state = PLAYER_PAUSED;
    } else if (p->state == PLAYER_BACKING && is_back(p)) {
        p->state = PLAYER_RUNNING;
        p->rate = p->clock_q == 0 ? FULL : 0; /* the table begins at rest */
        p->rest = 0;
    } else if (p->state == PLAYER_RUNNING && p->index + 1 == p->table.count) {
        if (p->port.is_in_corner(p->port.board))
            p->state = PLAYER_DONE;
        else
            fail(p, PLAYER_LOST_STEPS);
    }
}

static int moves(const struct player *p)
{
    return p->state == PLAYER_RUNNING || p->state == PLAYER_STOPPING || p->state == PLAYER_BACKING;
}

void player_tick(struct player *p, uint64_t now_us)
{
    uint32_t elapsed_us = (uint32_t)(now_us - p->now_us);

    p->now_us = now_us;
    if (!moves(p))
        return;
    if (p->state != PLAYER_STOPPING && p->port.door_is_open(p->port.board)) {
        if (may_burn(p))
            p->cut_us = clock_us(p) + elapsed_us;
        p->state = PLAYER_STOPPING;
        put(p); /* the laser goes out before anything else */
    }
    advance(p, elapsed_us);
    change_rate(p, elapsed_us);
    follow(p);
    put(p);
    end_phase(p);
}

uint64_t player_due(const struct player *p)
{
    uint64_t next;

    if (!moves(p))
        return PLAYER_NEVER;
    if (p->state != PLAYER_RUNNING || p->rate != FULL)
        return p->now_us + PLAYER_SLICE_US;
    next = p->row_us + wait_us(p->table.row(p->table.rows, p->index + 1));
    if (clock_us(p) < p->cut_us && p->cut_us < next)
        next = p->cut_us;
    return p->now_us + (next - clock_us(p));
}
