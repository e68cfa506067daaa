#include "estancia/label/lazy_labeler.hpp"

#include <utility>

#include "estancia/core/error.hpp"

namespace estancia {

OnDemandNetwork::OnDemandNetwork(const ModelSpec& spec, std::string engine, Open open)
    : NetworkLabeler(spec, std::move(engine)), open_(std::move(open)) {}

Labeler& OnDemandNetwork::network() const {
  if (network_) return *network_;
  network_ = open_();
  if (network_->identity() != identity())
    throw Error(ErrorCode::corruptFile,
                "model " + spec().name + " was changed while it was used; start again");
  return *network_;
}

LexicalDescriptor OnDemandNetwork::infer(const Prepared& prepared) {
  return network().infer(prepared);
}

std::vector<LabelResult> OnDemandNetwork::inferBatch(std::span<const Prepared> batch) {
  return network().inferBatch(batch);
}

std::size_t OnDemandNetwork::batchSize() const {
  return network().batchSize();
}

}  // namespace estancia
