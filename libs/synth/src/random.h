// Seeded random numbers that are the same with every standard library, in independent streams by name.
#pragma once

#include <cstdint>
#include <random>
#include <string_view>

namespace lake::synth {

class Random {
 public:
  // FNV-1a of the name, mixed with seed and index.
  Random(std::uint64_t seed, std::string_view stream, std::uint64_t index = 0);

  double Uniform(double low = 0, double high = 1);
  double Normal();                 // mean 0, standard deviation 1; Marsaglia's polar method
  int Integer(int low, int high);  // both included

 private:
  std::mt19937_64 engine_;
};

}  // namespace lake::synth
