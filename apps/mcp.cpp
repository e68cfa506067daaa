// estancia mcp: a map for agents, by the Model Context Protocol on standard input and output.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/site/mcp.hpp"

#include <unistd.h>

#include "common.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/live/map_file_view.hpp"

namespace estancia::apps {

void addMcpCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "mcp", "Let agents ask a map: a server of the Model Context Protocol on standard input and output");
  auto map = std::make_shared<std::string>();
  command->add_option("MAP", *map, "The map file; read again when it changes")->required();
  addExamples(*command, "  estancia mcp home.estancia");
  command->callback([map] {
    const MapFileView view(*map);
    McpServer server(view);
    serveMcp(server, STDIN_FILENO, STDOUT_FILENO, interrupted);
  });
}

}  // namespace estancia::apps
