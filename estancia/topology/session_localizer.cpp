// Localization in the map that a session makes.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/topology/localizer.hpp"
#include "estancia/topology/localizer_map.hpp"
#include "estancia/topology/mapper_impl.hpp"
#include "estancia/topology/session_impl.hpp"

namespace estancia {
namespace {

const LocalizerOptions& checked(const LocalizerOptions& options) {
  validate(options);
  return options;
}

}  // namespace

Localizer::Localizer(MappingSession& session, const LocalizerOptions& options)
    : Localizer(std::make_shared<const LocalizerMap>(
                    readLocalizerMap(session.impl_->written(), session.impl_->mapper.impl().bankAtRest(),
                                     checked(options).maxImages)),
                options) {}

}  // namespace estancia
