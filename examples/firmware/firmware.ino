// Firmware of a tactile array: reads all taxels at a set rate and sends them as native frames.
//
// Fill in read_taxels; the rest is complete. Until then all taxels of a test pattern are pressed for one second of four,
// so that `tactile live` shows events. `tactile new firmware NAME --array FILE.toml` writes the configuration.

#include "tactile_native.h"

// begin of the configuration
const uint32_t RATE_HZ = 100, BAUDRATE = 921600;
const uint32_t FINGERS = 2, MOST_TAXELS = 64;
typedef int16_t value_t;
#define SEND tactile_encode_int16
tactile_board boards[FINGERS] = {  // number, rows, columns, first sequence number
  {0, 2, 2, 0},  // finger: the host computes strain = 1e-05 * shear count, 1e-05 * normal count
  {1, 8, 8, 0},  // palm: the host computes strain = 1e-05 * shear count, 1e-05 * normal count
};
const float GAINS[FINGERS][3] = {{1e-05, 1e-05, 1e-05}, {1e-05, 1e-05, 1e-05}};  // quantity per count of x, y, z
const float TOUCH[FINGERS][3] = {{0.0, 0.0, 0.01}, {0.0, 0.0, 0.01}};  // quantity of the test pattern
// end of the configuration

const uint32_t PERIOD = 1000000ul / RATE_HZ;  // [us]
value_t values[3 * MOST_TAXELS];
uint8_t frame[TACTILE_FRAME_SIZE(MOST_TAXELS, value_t)];
uint64_t clock_us = 0;
uint32_t last = 0;

// FILL IN: write x, y, z of every taxel of the array `finger`, row by row, into `values`.
void read_taxels(uint8_t finger, value_t *values) {
  bool pressed = clock_us / 1000000 % 4 == 3;
  uint32_t count = 3ul * boards[finger].rows * boards[finger].cols;
  for (uint32_t i = 0; i < count; i++)
    values[i] = pressed ? TOUCH[finger][i % 3] / GAINS[finger][i % 3] : 0;
}

void setup() {
  Serial.begin(BAUDRATE);
  last = micros();
  Serial.write((uint8_t)0);  // ends any noise before the first frame
}

void loop() {
  uint32_t now = micros(), periods = (now - last) / PERIOD;  // the difference is right when micros() wraps
  uint64_t time = tactile_time(&clock_us, now);                         // also while nothing is sent
  if (!periods || !Serial) return;
  last += periods * PERIOD;
  for (uint8_t finger = 0; finger < FINGERS; finger++) {
    read_taxels(finger, values);
    boards[finger].sequence += periods - 1;  // periods that were missed: the host counts them
    Serial.write(frame, SEND(&boards[finger], values, time, frame));
  }
}
