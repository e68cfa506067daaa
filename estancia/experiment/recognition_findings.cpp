#include "estancia/experiment/recognition_findings.hpp"

#include <fmt/format.h>

#include "estancia/experiment/recognition_by_noise.hpp"
#include "estancia/experiment/recognition_tables.hpp"

namespace estancia {

Findings findingsOf(const RecognitionResults& results) {
  Findings findings;
  findings.title = "Objects in noise";
  findings.summary = bestByNoise(results);
  addOverviews(results, findings);
  addOverall(results, findings);
  addCurves(results, findings);
  addThesisTables(results, findings);
  std::size_t failed = 0, all = 0;
  for (const RecognitionCell& cell : results.cells) {
    failed += cell.failed;
    all += cell.pairs + cell.absent;
  }
  if (failed > 0)
    findings.notes.push_back(
        fmt::format("In {} of {} cases the scene or the model had nothing that could be described; they "
                    "count as not found.",
                    failed, all));
  return findings;
}

}  // namespace estancia
