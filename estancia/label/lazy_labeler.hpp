// Lazy network: opened at its first frame; a run whose labels are all cached opens none.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "estancia/label/network_labeler.hpp"

namespace estancia {

/// Knows its words and identity at once; what is wrong with the network itself shows at the first frame.
class OnDemandNetwork final : public NetworkLabeler {
 public:
  using Open = std::function<std::unique_ptr<Labeler>()>;
  OnDemandNetwork(const ModelSpec& spec, std::string engine, Open open);

  LexicalDescriptor infer(const Prepared& prepared) override;
  std::vector<LabelResult> inferBatch(std::span<const Prepared> batch) override;
  std::size_t batchSize() const override;

 private:
  Labeler& network() const;

  Open open_;
  mutable std::unique_ptr<Labeler> network_;
};

}  // namespace estancia
