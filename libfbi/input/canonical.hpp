/// A JSON text without what does not matter, to compare two inputs.
#pragma once

#include <string>
#include <vector>

namespace fbi::input {

/// The same JSON value without comments and white space, keys sorted, and without the entries that the JSON pointers
/// `left_out` name ("/time/end"). Throws std::invalid_argument when `text` is not JSON.
std::string canonical_text(const std::string& text, const std::vector<std::string>& left_out);

}  // namespace fbi::input
