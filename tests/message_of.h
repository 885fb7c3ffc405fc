// What refusals say.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <typeinfo>

#include "lake/core/error.h"

namespace lake {

// The message of the exception that an action ends with; empty if it ends well. An exception of another type than this,
// which gives a program another exit code, is a failure.
template <typename Exception, typename Action>
std::string MessageOf(const Action& action) {
  try {
    action();
  } catch (const Exception& error) {
    EXPECT_EQ(typeid(error), typeid(Exception)) << error.what();
    return error.what();
  }
  return {};
}

// The same of an Error of any type.
template <typename Action>
std::string MessageOf(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

}  // namespace lake
