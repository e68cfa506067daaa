#include "estancia/describe/descriptor.hpp"

#include "estancia/describe/phog.hpp"

namespace estancia {

std::vector<std::pair<std::string, std::string>> descriptorTypes() {
  return {{"phog", "pyramid histogram of oriented gradients (630): which way edges run, where"}};
}

std::unique_ptr<Descriptor> findDescriptor(const std::string& name) {
  if (name == "phog") return std::make_unique<Phog>();
  return nullptr;
}

}  // namespace estancia
