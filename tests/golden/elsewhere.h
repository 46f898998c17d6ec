// SPDX-License-Identifier: MIT
// Entries that no test of this program reads yet: counted, named, and not passed over in silence. Whoever writes the GOLDEN test
// of an entry takes its row out; a row with a test fails the run, like an entry with neither.
#pragma once

namespace plumb::golden {

inline constexpr const char* kElsewhere[] = {
    // Part 4: rays through corners, shared by pixels.
    "s1841_corner_sharing",
    "s1841_corner_average",
};

}  // namespace plumb::golden
