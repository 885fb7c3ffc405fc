// What holds for every stroke program. What belongs to one is in stroke_table.h, the pins are in pins.h of the board.
#ifndef LAKE_CONFIG_H
#define LAKE_CONFIG_H

#include "stroke_table.h"

#define END_STOP_RELEASE_MS 3    // a pressed end stop counts as released once it has been so for that long
#define WIRE_WRONG_MS 10         // how long end stops must contradict what is known, at rest
#define LAKE_PLACE_UM 2000L      // how far the potentiometer may be from home and from the program's start
#define LAKE_FOLLOWING_UM 3000L  // and from the plan
#define STATUS_PERIOD_MS 100u
#define JOG_MAX_MS 10000
#define HOME_TRIES 3                     // that may fail until power is off and on
#define FREE_UM 300L                     // away from an end stop that is not pressed, after which it must stay so
#define STOP_PLACE_UM 1000L              // how far an end stop may be from where it belongs
#define SOFT_LIMIT_SLACK_UM 50           // rounding of the table, not room to move
#define LAKE_LEAST_BEYOND_UM 250L        // that a measured stroke may pass a soft limit by
#define SLOW 5                           // 2^5 ms of smoothing, where small movements are watched
#define LAKE_DRIFT_MOST_NM 1000000000UL  // the bound stops growing at 1 m

#endif
