#include "input/suggest.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>

namespace fbi::input {

int edit_distance(const std::string& a, const std::string& b) {
  const std::size_t rows = a.size() + 1, columns = b.size() + 1;
  std::vector<int> distance(rows * columns);
  for (std::size_t i = 0; i < rows; ++i) distance[i * columns] = static_cast<int>(i);
  for (std::size_t j = 0; j < columns; ++j) distance[j] = static_cast<int>(j);
  for (std::size_t i = 1; i < rows; ++i) {
    for (std::size_t j = 1; j < columns; ++j) {
      const int replace = a[i - 1] == b[j - 1] ? 0 : 1;
      int best = std::min({distance[(i - 1) * columns + j] + 1, distance[i * columns + j - 1] + 1,
                           distance[(i - 1) * columns + j - 1] + replace});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        best = std::min(best, distance[(i - 2) * columns + j - 2] + 1);
      }
      distance[i * columns + j] = best;
    }
  }
  return distance.back();
}

std::string nearest_word(const std::string& word, const std::vector<std::string>& known) {
  const auto lower = [](std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
    return text;
  };
  std::string best;
  int best_distance = std::max(1, static_cast<int>(std::min<std::size_t>(word.size(), 1000)) / 3) + 1;
  for (const std::string& candidate : known) {
    if (word.size() > 100 || candidate.size() > 100) continue;
    const int distance = edit_distance(lower(word), lower(candidate));
    if (distance < best_distance && distance < static_cast<int>(candidate.size())) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

std::string did_you_mean(const std::string& word, const std::vector<std::string>& known) {
  const std::string best = nearest_word(word, known);
  return best.empty() ? "" : "; did you mean \"" + best + "\"?";
}

std::string number_text(double value) {
  char buffer[40];
  const std::to_chars_result result = std::to_chars(buffer, buffer + sizeof buffer, value);
  return std::string(buffer, result.ptr);
}

std::string list_text(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 == words.size() ? " or " : ", ";
    text += words[i];
  }
  return text;
}

}  // namespace fbi::input
