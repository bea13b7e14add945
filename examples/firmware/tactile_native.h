/* Encoder of native frames of the tactile layer, for firmware: COBS, CRC-16, sequence number, device time.

   C99 and C++, without a library and without heap; any byte order; about 1 KB of code. A frame is the COBS code of this
   packet, then one zero byte (little endian, no padding):

     u8 version = 1, u8 board, u8 rows, u8 cols, u8 kind of value (0 int16, 1 float32)
     u32 sequence number of the board, u64 device time [us]
     rows * cols * 3 values: x, y, z of the first taxel, then of the next one along the row, row by row
     u16 CRC-16/IBM-3740 of all bytes before (polynomial 0x1021, start 0xFFFF, not reflected)

   Use: one tactile_board for each array, one buffer of TACTILE_FRAME_SIZE bytes, then for every reading

     size_t size = tactile_encode_int16(&board, values, tactile_time(&clock, micros()), buffer);
     Serial.write(buffer, size);

   Send one zero byte at start; it ends any noise before it. The host counts a gap in the sequence as lost frames, so
   add the number of frames that could not be sent to board.sequence. Sequence numbers continue at 0 after 2^32 - 1. */

#ifndef TACTILE_NATIVE_H
#define TACTILE_NATIVE_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum { TACTILE_VERSION = 1, TACTILE_INT16 = 0, TACTILE_FLOAT32 = 1, TACTILE_HEAD = 17, TACTILE_CRC = 2 };

/* Bytes of a packet of `taxels` taxels with values of type `type`, and of its frame with the overhead of COBS. */
#define TACTILE_PACKET_SIZE(taxels, type) (TACTILE_HEAD + 3u * (taxels) * sizeof(type) + TACTILE_CRC)
#define TACTILE_FRAME_SIZE(taxels, type) \
  (TACTILE_PACKET_SIZE(taxels, type) + TACTILE_PACKET_SIZE(taxels, type) / 254u + 2u)

/* One array: its number in the array description (0 for the first finger), its size, and the next sequence number. */
typedef struct {
  uint8_t board, rows, cols;
  uint32_t sequence;
} tactile_board;

/* State of the encoder of one frame: next byte to write, code byte of the current COBS block, CRC so far. */
typedef struct {
  uint8_t *next, *code;
  uint16_t crc;
} tactile_encoder;

/* Extend a counter of microseconds that wraps after 71.6 minutes to 64 bits. `clock` is 0 at start. Call it at least
   once in 71 minutes. */
static inline uint64_t tactile_time(uint64_t *clock, uint32_t micros) {
  *clock += (uint32_t)(micros - (uint32_t)*clock);
  return *clock;
}

/* Begin a COBS block: the code byte is the distance to the next zero. */
static inline void tactile_block(tactile_encoder *to) {
  to->code = to->next++;
  *to->code = 1;
}

/* Append a byte of the packet. */
static inline void tactile_put(tactile_encoder *to, uint8_t byte) {
  to->crc = (uint16_t)((to->crc >> 8) | (to->crc << 8)); /* eight steps of the polynomial at once */
  to->crc ^= byte;
  to->crc ^= (uint16_t)((to->crc & 0xFFu) >> 4);
  to->crc ^= (uint16_t)(to->crc << 12);
  to->crc ^= (uint16_t)((to->crc & 0xFFu) << 5);
  if (*to->code == 0xFF) tactile_block(to); /* a block has at most 254 bytes */
  if (byte == 0) {
    tactile_block(to);
  } else {
    *to->next++ = byte;
    ++*to->code;
  }
}

/* Append an unsigned number of `bytes` bytes, little endian. */
static inline void tactile_put_number(tactile_encoder *to, uint64_t number, uint8_t bytes) {
  while (bytes--) {
    tactile_put(to, (uint8_t)number);
    number >>= 8;
  }
}

/* Append a 32-bit number, little endian; faster than 64 bits on small processors. */
static inline void tactile_put_word(tactile_encoder *to, uint32_t word) {
  tactile_put(to, (uint8_t)word);
  tactile_put(to, (uint8_t)(word >> 8));
  tactile_put(to, (uint8_t)(word >> 16));
  tactile_put(to, (uint8_t)(word >> 24));
}

/* Begin a frame in the buffer `out`. */
static inline void tactile_begin(tactile_encoder *to, tactile_board *from, uint8_t kind, uint64_t time, uint8_t *out) {
  to->next = out;
  to->crc = 0xFFFF;
  tactile_block(to);
  tactile_put(to, TACTILE_VERSION);
  tactile_put(to, from->board);
  tactile_put(to, from->rows);
  tactile_put(to, from->cols);
  tactile_put(to, kind);
  tactile_put_word(to, from->sequence++);
  tactile_put_number(to, time, 8);
}

/* Append the CRC and the closing zero, and return the length of the frame in bytes. */
static inline size_t tactile_end(tactile_encoder *to, uint8_t *out) {
  tactile_put_number(to, to->crc, TACTILE_CRC);
  *to->next++ = 0;
  return (size_t)(to->next - out);
}

/* Encode a frame of integer readings into `out`, TACTILE_FRAME_SIZE(rows * cols, int16_t) bytes; return its length.

   `values`: x, y, z of rows * cols taxels; `time` [us] when they were read. The sequence number grows by one. */
static inline size_t tactile_encode_int16(tactile_board *from, const int16_t *values, uint64_t time, uint8_t *out) {
  tactile_encoder to;
  uint32_t count = 3ul * from->rows * from->cols;
  tactile_begin(&to, from, TACTILE_INT16, time, out);
  for (; count; count--, values++) {
    tactile_put(&to, (uint8_t)((uint16_t)*values & 0xFFu));
    tactile_put(&to, (uint8_t)((uint16_t)*values >> 8));
  }
  return tactile_end(&to, out);
}

/* The same for float readings, TACTILE_FRAME_SIZE(rows * cols, float) bytes; NaN is a taxel without a reading. */
static inline size_t tactile_encode_float32(tactile_board *from, const float *values, uint64_t time, uint8_t *out) {
  tactile_encoder to;
  uint32_t word, count = 3ul * from->rows * from->cols;
  tactile_begin(&to, from, TACTILE_FLOAT32, time, out);
  for (; count; count--, values++) {
    memcpy(&word, values, sizeof word);
    tactile_put_word(&to, word);
  }
  return tactile_end(&to, out);
}

#endif
