// A label with its probability, by name.
#pragma once

#include <string>

namespace estancia {

/// As sources say it whose words are no fixed list: programs, services, people.
struct Word {
  std::string label;
  float probability = 0;  ///< in [0, 1]
};

}  // namespace estancia
