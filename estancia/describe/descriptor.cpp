// SPDX-License-Identifier: Apache-2.0
#include "estancia/describe/descriptor.hpp"

#include "estancia/describe/esf.hpp"
#include "estancia/describe/gist.hpp"
#include "estancia/describe/phog.hpp"

namespace estancia {

Choices descriptorTypes() {
  return {{"phog", "pyramid histogram of oriented gradients (630): the directions of edges, by position"},
          {"gist", "spatial envelope (512): filter energies by scale, direction and position"},
          {"esf", "ensemble of shape functions (640), needs depth: the 3-D shape of the scene"}};
}

std::unique_ptr<Descriptor> findDescriptor(const std::string& name) {
  if (name == "phog") return std::make_unique<Phog>();
  if (name == "gist") return std::make_unique<Gist>();
  if (name == "esf") return std::make_unique<Esf>();
  return nullptr;
}

}  // namespace estancia
