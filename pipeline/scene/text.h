// SPDX-License-Identifier: MIT
// Text of untrusted files, for all readers: bytes, positions in them, numbers, names, and paths that files name. Everything here is
// independent of the locale. Every refusal is Error(Exit::input) and says where in the file.
#pragma once

#include "host/error.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

namespace plumb {

// Largest file that a reader accepts. Meshes address vertices by 32 bits, and a text vertex takes at least 8 bytes ("v 0 0 0\n"). So 4 GiB
// keeps every count of a text file below 2^29. It also bounds what a sparse file can make us allocate.
inline constexpr uint64_t kMaxFileBytes = uint64_t(4) << 30;

// Largest coordinate or matrix entry: 2^100 (about 1.27e30). Products of three stay finite after the divisions of the
// transform.
inline constexpr float kMaxCoordinate = 0x1p100f;

// Untrusted text made safe for a terminal: control characters and bytes that are not UTF-8 as \xNN, at most `maxChars` characters, "..." at
// the cut.
std::string printable(std::string_view text, size_t maxChars = 200);

// Location in a file, for messages: "file:line:column" (both from 1, columns in bytes), "file: byte N" (from 0), "file: /pointer". The file's
// name is made printable.
std::string locationOfLine(const std::filesystem::path&, size_t line, size_t column);
std::string locationOfByte(const std::filesystem::path&, uint64_t offset);
std::string locationOfPointer(const std::filesystem::path&, std::string_view pointer);
std::string printablePath(const std::filesystem::path&);
// Location of a part of a scene that is refused when it is drawn: "scene.toml:9:1: object 'arrow'", by its location or else by the file.
std::string locationOfPart(const std::string& location, const std::filesystem::path& file, std::string_view kind, std::string_view name);

// Case of letters for editDistance() (Levenshtein's, for "did you mean"): anyCase takes ASCII letters of both cases as equal.
enum class Letters { asWritten, anyCase };
size_t editDistance(std::string_view a, std::string_view b, Letters letters);

// Bytes of a whole file. A missing file is refused, and one that is not regular (folder, FIFO, device, socket), without blocking on it. More
// than `maxBytes` are refused before anything is allocated. A file that shrinks while it is read is refused.
std::string readWholeFile(const std::filesystem::path&, uint64_t maxBytes = kMaxFileBytes);

// Name of a text's encoding that no reader takes, by its first bytes: "UTF-16" or "UTF-32"; null for all other bytes.
const char* otherEncoding(std::string_view bytes);
// Takes the byte order mark of UTF-8 off a text. A text of UTF-16 or UTF-32 is refused.
void takeByteOrderMark(std::string& text, const std::filesystem::path&);

// Path of a reference written in file `from`, e.g. of a material library. Unless `allowOutside`, it must be relative, contain no "..", and
// resolve (symbolic links included) to something in the folder of `from` or below. `location` is where it is written, `field` its name. The
// file need not exist.
std::filesystem::path resolveReference(const std::filesystem::path& from, std::string_view reference, bool allowOutside,
                                       const std::string& location, std::string_view field);

// Number `value` of `field` as float32; NaN, infinity, and magnitudes above `limit` are refused at `location`.
float finiteFloat(double value, const std::string& location, std::string_view field, double limit = kMaxCoordinate);

// Reads a number without a locale: an optional sign, decimal, all of `word`. False: not a number. NaN and infinity are numbers here. A
// value too small for float32 gives the smallest denormal of its sign, so that finishMesh() counts it; one too large gives infinity.
bool parseFloat(std::string_view word, float& value);
bool parseDouble(std::string_view word, double& value);  // as parseFloat(), in binary64
bool parseInteger(std::string_view word, int64_t& value);

// Scanner of the text of a file. Lines end at \n, \r\n or \r. Locations are computed only for a refusal.
class Scanner {
public:
    Scanner(std::string_view text, std::filesystem::path file, size_t offset = 0)
        : text_(text), file_(std::move(file)), at_(text.data() + offset), end_(text.data() + text.size()), token_(at_) {}

    bool atEnd() const { return at_ == end_; }
    size_t offset() const { return size_t(at_ - text_.data()); }
    const std::filesystem::path& file() const { return file_; }

    // Next word (a run without blanks) within the line, empty at the end of the line. With `continued`, a backslash before the line's end
    // joins the next line (OBJ).
    std::string_view word();
    // Rest of the line without surrounding blanks (a trailing comment stays).
    std::string_view restOfLine();
    void skipLine();  // to the start of the next line
    bool lineEnds();  // only blanks are left in the line
    // Next word after blanks, line ends and comments that start with `comment`; empty at the end of the text.
    std::string_view wordAnywhere(char comment = '#');

    float number(std::string_view word, std::string_view field, float limit = kMaxCoordinate);  // finite, or refused
    float number(std::string_view field) { return number(word(), field); }
    double coordinate(std::string_view word, std::string_view field);  // finite and at most kMaxCoordinate, or refused; in binary64
    double coordinate(std::string_view field) { return coordinate(word(), field); }
    int64_t integer(std::string_view word, std::string_view field);

    // Location where the last word began, or where a missing word should be.
    std::string location() const { return locationAt(token_); }
    std::string locationAt(const char* at) const;
    [[noreturn]] void refuse(std::string_view message) const;

    bool continued = false;

private:
    template <class Real>
    Real real(std::string_view word, std::string_view field, Real limit);
    bool skipBlanks();  // false at the end of the line or text

    std::string_view text_;
    std::filesystem::path file_;
    const char* at_;
    const char* end_;
    const char* token_;  // start of the last word
};

}  // namespace plumb
