// SPDX-License-Identifier: Apache-2.0
#include "words/real_words.hpp"

#include "support/support.hpp"

namespace estancia::test {

WordNetTexts tinyWordNet() {
  const std::string license = "  1 This software and database is being provided to you, the LICENSEE.  \n";
  return {
      {"data.noun", license +
                        R"(00000100 03 n 01 entity 0 002 ~ 00000200 n 0000 ~ 00000600 n 0000 | that which is  
00000200 05 n 02 animal 0 beast 0 003 @ 00000100 n 0000 ~ 00000300 n 0000 ~ 00000400 n 0000 | a living entity  
00000300 05 n 03 dog 0 domestic_dog 0 Canis_familiaris 0 001 @ 00000200 n 0000 | an animal that barks; "the dog barked in the kitchen"  
00000400 05 n 01 mouse 0 001 @ 00000200 n 0000 | a small animal  
00000500 06 n 02 mouse 1 computer_mouse 0 001 @ 00000100 n 0000 | a thing that is moved by hand  
00000600 06 n 01 room 0 004 @ 00000100 n 0000 ~ 00000700 n 0000 ~ 00000800 n 0000 %p 00001000 n 0000 | a part of a house  
00000700 06 n 02 living_room 0 sitting-room 0 001 @ 00000600 n 0000 | a room where an animal may rest  
00000800 06 n 01 kitchen 0 001 @ 00000600 n 0000 | a room to cook in  
00000900 06 n 02 knife 0 kitchen_knife 0 001 @ 00000100 n 0000 | it cuts in the kitchen  
00001000 06 n 0a stove 0 kitchen_stove 0 range 0 cooking_stove 0 s5 0 s6 0 s7 0 s8 0 s9 0 T-shirt 0 001 @ 00000100 n 0000 | a thing on which a cook cooks  
)"},
      {"data.verb",
       license +
           R"(00000100 30 v 01 cook 0 001 + 00001000 n 0102 01 + 08 00 | make hot in the kitchen  
00000200 30 v 02 wash 0 lave 0 000 02 + 02 00 + 08 00 | clean with water  
)"},
      {"data.adj", license + R"(00000100 00 a 01 hot 0 001 & 00000200 a 0000 | of a high temperature  
00000200 00 s 01 burning(ip) 0 001 & 00000100 a 0000 | very hot  
)"},
      {"data.adv", license + "00000100 02 r 01 quickly 0 000 | with speed  \n"},
      {"index.noun", license + R"(animal n 1 2 @ ~ 1 0 00000200  
beast n 1 2 @ ~ 1 0 00000200  
canis_familiaris n 1 1 @ 1 0 00000300  
computer_mouse n 1 1 @ 1 0 00000500  
dog n 1 1 @ 1 1 00000300  
domestic_dog n 1 1 @ 1 0 00000300  
entity n 1 1 ~ 1 0 00000100  
kitchen n 1 1 @ 1 0 00000800  
kitchen_knife n 1 1 @ 1 0 00000900  
knife n 1 1 @ 1 0 00000900  
living_room n 1 1 @ 1 0 00000700  
mouse n 2 1 @ 2 1 00000400 00000500  
room n 1 3 @ ~ %p 1 0 00000600  
sitting-room n 1 1 @ 1 0 00000700  
stove n 1 1 @ 1 0 00001000  
t-shirt n 1 1 @ 1 0 00001000  
)"},
      {"index.verb", license + R"(cook v 1 1 + 1 1 00000100  
lave v 1 0 1 0 00000200  
wash v 1 0 1 0 00000200  
)"},
      {"index.adj", license + R"(burning a 1 1 & 1 0 00000200  
hot a 1 1 & 1 0 00000100  
)"},
      {"index.adv", license + "quickly r 1 0 1 0 00000100  \n"},
      {"noun.exc", "knives knife\nmice mouse\n"},
      {"verb.exc", "cooken cook wash\n"},
      {"adj.exc", ""},
      {"adv.exc", ""},
      {"cntlist.rev",
       "burning%5:00:00:hot:00 1 3\ncook%2:30:00:: 1 7\ndog%1:05:00:: 1 42\nmouse%1:05:00:: 1 5\n"
       "mouse%1:06:01:: 2 1\n"},
  };
}

void writeWordNet(const WordNetTexts& texts, const std::filesystem::path& folder) {
  for (const auto& [name, text] : texts) writeFile(folder / name, text);
}

}  // namespace estancia::test
