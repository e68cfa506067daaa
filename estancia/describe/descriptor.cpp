#include "estancia/describe/descriptor.hpp"

#include "estancia/describe/esf.hpp"
#include "estancia/describe/gist.hpp"
#include "estancia/describe/phog.hpp"

namespace estancia {

std::vector<std::pair<std::string, std::string>> descriptorTypes() {
  return {{"phog", "pyramid histogram of oriented gradients (630): which way edges run, where"},
          {"gist", "spatial envelope (512): how much goes on at which scale and direction, where"},
          {"esf", "ensemble of shape functions (640), needs depth: the shape of what is seen"}};
}

std::unique_ptr<Descriptor> findDescriptor(const std::string& name) {
  if (name == "phog") return std::make_unique<Phog>();
  if (name == "gist") return std::make_unique<Gist>();
  if (name == "esf") return std::make_unique<Esf>();
  return nullptr;
}

}  // namespace estancia
