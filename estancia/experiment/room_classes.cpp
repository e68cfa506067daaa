#include "estancia/experiment/room_classes.hpp"

#include <algorithm>
#include <map>

#include "estancia/experiment/room_table.hpp"

namespace estancia {
namespace {

/// Whether the second name may be the next of the first.
bool follows(const std::string& first, const std::string& second) {
  const std::string a = imageNumber(first), b = imageNumber(second);
  const auto isNumber = [](const std::string& text) {
    return !text.empty() && text.size() < 18 && text.find_first_not_of("0123456789") == std::string::npos;
  };
  return !isNumber(a) || !isNumber(b) || std::stoull(b) == std::stoull(a) + 1;
}

}  // namespace

std::vector<std::string> classesOfRuns(const std::vector<Frame>& frames,
                                       const std::vector<std::string>& rooms,
                                       const std::vector<std::string>& marks, std::size_t parts) {
  std::vector<std::string> classes(frames.size());
  std::map<std::string, std::size_t> counts;  // classes of each room so far
  for (std::size_t begin = 0, end = 0; begin < frames.size(); begin = end) {
    for (end = begin + 1; end < frames.size() && rooms[end] == rooms[begin] &&
                          (marks.empty() || marks[end] == marks[begin]) &&
                          follows(frames[end - 1].name, frames[end].name);)
      ++end;
    if (rooms[begin].empty()) continue;
    const std::size_t length = end - begin, pieces = std::min(parts, length);
    std::size_t& count = counts[rooms[begin]];
    for (std::size_t i = begin; i < end; ++i)
      classes[i] = rooms[begin] + " " + std::to_string(count + (i - begin) * pieces / length + 1);
    count += pieces;
  }
  return classes;
}

}  // namespace estancia
