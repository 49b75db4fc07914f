/// "did you mean": the known word nearest to a misspelt one, and numbers as text.
#pragma once

#include <string>
#include <vector>

namespace fbi::input {

/// Number of insertions, deletions, replacements and swaps of neighbors that turn `a` into `b` (optimal string
/// alignment).
int edit_distance(const std::string& a, const std::string& b);

/// The word of `known` nearest to `word`, ignoring case, or "" when none is near enough (a third of its length, at
/// least one edit).
std::string nearest_word(const std::string& word, const std::vector<std::string>& known);

/// "; did you mean "X"?" for the nearest known word, or "" when there is none.
std::string did_you_mean(const std::string& word, const std::vector<std::string>& known);

/// The shortest text that reads back as exactly `value`.
std::string number_text(double value);

/// Words as a list for people: a, b or c.
std::string list_text(const std::vector<std::string>& words);

}  // namespace fbi::input
