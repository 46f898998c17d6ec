// SPDX-License-Identifier: MIT
#include "pipeline/scene/text.h"

#include "pipeline/scene/input.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <vector>

namespace plumb {
namespace {

// Length of the well-formed UTF-8 sequence at text[at] that is safe to print, 0 for none. C1 controls (U+0080 to
// U+009F), which some terminals obey, and bidirectional overrides (U+202A to U+202E, U+2066 to U+2069) are not safe.
size_t printableSequence(std::string_view text, size_t at) {
    const auto byte = [&](size_t i) { return i < text.size() ? uint8_t(text[i]) : uint8_t(0); };
    const uint8_t first = byte(at);
    if (first >= 0x20 && first < 0x7f) return 1;
    const size_t length = first >= 0xc2 && first <= 0xdf ? 2 : (first & 0xf0) == 0xe0 ? 3 : first >= 0xf0 && first <= 0xf4 ? 4 : 0;
    if (length == 0) return 0;
    uint32_t code = first & (0xffu >> (length + 1));
    for (size_t i = 1; i < length; ++i) {
        if ((byte(at + i) & 0xc0) != 0x80) return 0;
        code = code << 6 | (byte(at + i) & 0x3f);
    }
    constexpr uint32_t kSmallest[] = {0, 0, 0x80, 0x800, 0x10000};
    if (code < kSmallest[length] || code > 0x10ffff || (code >= 0xd800 && code <= 0xdfff)) return 0;
    if (code < 0xa0 || (code >= 0x2028 && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069)) return 0;
    return length;
}

struct FileDescriptor {
    int fd;
    ~FileDescriptor() {
        if (fd >= 0) ::close(fd);
    }
};

void refuseUnlessRegular(const struct stat& status, const std::string& location) {
    if (S_ISREG(status.st_mode)) return;
    const char* kind = S_ISDIR(status.st_mode)    ? "a folder"
                       : S_ISFIFO(status.st_mode) ? "a FIFO"
                       : S_ISSOCK(status.st_mode) ? "a socket"
                                                  : "a device";
    throw inputError(location, fmt::format("is {}, not a regular file", kind));
}

bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
bool isLineEnd(char c) { return c == '\n' || c == '\r'; }

}  // namespace

std::string printable(std::string_view text, size_t maxChars) {
    std::string out;
    size_t chars = 0;
    for (size_t at = 0; at < text.size();) {
        const size_t length = printableSequence(text, at);
        const size_t width = length ? 1 : 4;
        if (chars + width > maxChars) return out + "...";
        if (length)
            out += text.substr(at, length);
        else
            out += fmt::format("\\x{:02x}", uint8_t(text[at]));
        chars += width;
        at += length ? length : 1;
    }
    return out;
}

size_t editDistance(std::string_view a, std::string_view b, Letters letters) {
    const auto same = [&](char x, char y) {
        const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; };
        return letters == Letters::anyCase ? lower(x) == lower(y) : x == y;
    };
    std::vector<size_t> row(b.size() + 1);
    for (size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (size_t i = 1; i <= a.size(); ++i) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= b.size(); ++j) {
            const size_t above = row[j];
            row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + !same(a[i - 1], b[j - 1])});
            diagonal = above;
        }
    }
    return row[b.size()];
}

std::string printablePath(const std::filesystem::path& path) { return printable(path.native()); }

std::string locationOfPart(const std::string& location, const std::filesystem::path& file, std::string_view kind, std::string_view name) {
    return fmt::format("{}: {}{}", location.empty() ? printablePath(file) : location, kind,
                       name.empty() ? "" : fmt::format(" '{}'", printable(name, 64)));
}

std::string locationOfLine(const std::filesystem::path& file, size_t line, size_t column) {
    return fmt::format("{}:{}:{}", printablePath(file), line, column);
}
std::string locationOfByte(const std::filesystem::path& file, uint64_t offset) {
    return fmt::format("{}: byte {}", printablePath(file), offset);
}
std::string locationOfPointer(const std::filesystem::path& file, std::string_view pointer) {
    return fmt::format("{}: {}", printablePath(file), printable(pointer));
}

std::string readWholeFile(const std::filesystem::path& path, uint64_t maxBytes) { return readWholeFileTelling(path, maxBytes, {}); }

std::string readWholeFileTelling(const std::filesystem::path& path, uint64_t maxBytes,
                                 const std::function<void(uint64_t, uint64_t)>& tell) {
    const std::string location = printablePath(path);
    const auto refuse = [&] { return inputError(location, std::strerror(errno)); };
    if (path.native().find('\0') != std::string::npos) throw inputError(location, "the name has a NUL character");
    struct stat status {};
    // The file's kind is checked before opening, because opening alone can have effects on a device. O_NONBLOCK and the second check cover
    // an exchange in between.
    if (::stat(path.c_str(), &status) != 0) throw refuse();
    refuseUnlessRegular(status, location);
    const FileDescriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY)};
    if (file.fd < 0 || ::fstat(file.fd, &status) != 0) throw refuse();
    refuseUnlessRegular(status, location);
    const uint64_t size = uint64_t(status.st_size);
    if (size > maxBytes) throw inputError(location, fmt::format("has {} bytes; at most {} are read", size, maxBytes));
    std::string bytes(size, '\0');
    for (size_t done = 0; done < size;) {
        if (tell) tell(done, size);
        const ssize_t got = ::read(file.fd, bytes.data() + done, std::min<size_t>(size - done, size_t(1) << 22));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) throw refuse();
        if (got == 0) throw inputError(locationOfByte(path, done), fmt::format("the file ends before its {} bytes", size));
        done += size_t(got);
    }
    return bytes;
}

std::filesystem::path resolveReference(const std::filesystem::path& from, std::string_view reference, bool allowOutside,
                                       const std::string& location, std::string_view field) {
    namespace fs = std::filesystem;
    const auto refuse = [&](std::string_view why) {
        return inputError(location, fmt::format("{} '{}' {}", field, printable(reference), why));
    };
    if (reference.empty()) throw refuse("is empty");
    if (reference.find('\0') != std::string_view::npos) throw refuse("has a NUL character");
    const fs::path written{std::string(reference)};
    const fs::path folder = from.parent_path().empty() ? fs::path(".") : from.parent_path();
    fs::path target = folder / written;
    if (allowOutside) return target;
    if (written.is_absolute()) throw refuse("is absolute; --allow-outside permits it");
    for (const fs::path& part : written)
        if (part == "..") throw refuse("leaves the folder of the file that names it; --allow-outside permits it");
    std::error_code failed;
    const fs::path root = fs::weakly_canonical(folder, failed);
    const fs::path real = failed ? fs::path() : fs::weakly_canonical(target, failed);
    if (failed) throw refuse("cannot be resolved: " + failed.message());
    const auto [rootEnd, rest] = std::mismatch(root.begin(), root.end(), real.begin(), real.end());
    if (rootEnd != root.end()) throw refuse("leads outside the folder of the file that names it; --allow-outside permits it");
    return target;
}

const char* otherEncoding(std::string_view bytes) {
    for (const std::string_view mark : {std::string_view("\xff\xfe\0\0", 4), std::string_view("\0\0\xfe\xff", 4)})
        if (bytes.starts_with(mark)) return "UTF-32";
    for (const std::string_view mark : {"\xff\xfe", "\xfe\xff"})
        if (bytes.starts_with(mark)) return "UTF-16";
    // Without a mark: ASCII with a NUL byte before or behind each character.
    constexpr size_t kBytes = 8;
    const std::string_view head = bytes.substr(0, kBytes);
    const auto isText = [&](size_t first) {
        for (size_t i = 0; i < kBytes; ++i) {
            const uint8_t byte = uint8_t(head[i]);
            if (i % 2 == first ? byte != '\t' && byte != '\n' && byte != '\r' && (byte < 0x20 || byte > 0x7e) : byte != 0) return false;
        }
        return true;
    };
    return head.size() == kBytes && (isText(0) || isText(1)) ? "UTF-16" : nullptr;
}

void takeByteOrderMark(std::string& text, const std::filesystem::path& file) {
    if (const char* encoding = otherEncoding(text))
        throw inputError(locationOfLine(file, 1, 1), fmt::format("the text is {}; only UTF-8 is read", encoding));
    if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
}

float finiteFloat(double value, const std::string& location, std::string_view field, double limit) {
    if (std::isnan(value)) throw inputError(location, fmt::format("{} is NaN", field));
    if (std::isinf(value)) throw inputError(location, fmt::format("{} is infinite", field));
    if (std::abs(value) > limit) throw inputError(location, fmt::format("{} is {}; the largest magnitude is {}", field, value, limit));
    // A number too small for float32 becomes its smallest denormal, so that finishMesh() counts it.
    const float rounded = float(value);
    return rounded == 0 && value != 0 ? std::copysign(std::numeric_limits<float>::denorm_min(), float(value)) : rounded;
}

template <class Real>
static bool parseReal(std::string_view word, Real& value) {
    const char* at = word.data();
    const char* const end = at + word.size();
    if (at != end && *at == '+' && ++at != end && *at == '-') return false;  // from_chars knows no leading plus
    const auto [rest, error] = std::from_chars(at, end, value);
    if (rest != end || at == end) return false;
    if (error == std::errc()) return true;
    if (error != std::errc::result_out_of_range) return false;
    // Side of the overflow, which from_chars does not tell: the decimal position of the first digit that is not 0, plus the exponent.
    // float32 holds 1.4e-45 to 3.4e38 and binary64 more either way, so the sign of the sum decides.
    const bool negative = *at == '-';
    int64_t digits = 0, exponent = 0;
    bool point = false, significant = false;
    const char* p = at + negative;
    for (; p != end && *p != 'e' && *p != 'E'; ++p) {
        if (*p == '.') {
            point = true;
            continue;
        }
        if (*p != '0') significant = true;
        if (significant && !point) ++digits;
        if (!significant && point) --digits;
    }
    if (p != end) {
        if (++p != end && *p == '+') ++p;
        const auto parsed = std::from_chars(p, end, exponent);
        if (parsed.ec == std::errc::result_out_of_range) exponent = *p == '-' ? -(int64_t(1) << 40) : int64_t(1) << 40;
    }
    const Real magnitude = digits + exponent > 0 ? std::numeric_limits<Real>::infinity() : std::numeric_limits<Real>::denorm_min();
    value = negative ? -magnitude : magnitude;
    return true;
}

bool parseFloat(std::string_view word, float& value) { return parseReal(word, value); }
bool parseDouble(std::string_view word, double& value) { return parseReal(word, value); }

bool parseInteger(std::string_view word, int64_t& value) {
    const char* at = word.data();
    const char* const end = at + word.size();
    if (at != end && *at == '+' && ++at != end && *at == '-') return false;
    const auto [rest, error] = std::from_chars(at, end, value);
    return error == std::errc() && rest == end && at != end;
}

bool Scanner::skipBlanks() {
    while (at_ != end_) {
        if (isBlank(*at_)) {
            ++at_;
        } else if (continued && *at_ == '\\' && at_ + 1 != end_ && isLineEnd(at_[1])) {
            at_ += at_[1] == '\r' && at_ + 2 != end_ && at_[2] == '\n' ? 3 : 2;
        } else {
            return !isLineEnd(*at_);
        }
    }
    return false;
}

std::string_view Scanner::word() {
    const bool any = skipBlanks();
    token_ = at_;
    if (!any) return {};
    while (at_ != end_ && !isBlank(*at_) && !isLineEnd(*at_)) {
        if (continued && *at_ == '\\' && at_ + 1 != end_ && isLineEnd(at_[1])) break;
        ++at_;
    }
    return {token_, size_t(at_ - token_)};
}

std::string_view Scanner::restOfLine() {
    skipBlanks();
    token_ = at_;
    while (at_ != end_ && !isLineEnd(*at_)) ++at_;
    const char* last = at_;
    while (last != token_ && isBlank(last[-1])) --last;
    return {token_, size_t(last - token_)};
}

void Scanner::skipLine() {
    // True in a comment, which ends with its line even when that ends with the backslash of a path.
    bool comment = !continued || (token_ != at_ && *token_ == '#');
    while (at_ != end_ && !isLineEnd(*at_)) {
        comment |= *at_ == '#';
        const bool joins = !comment && *at_ == '\\' && at_ + 1 != end_ && isLineEnd(at_[1]);
        at_ += joins && at_[1] == '\r' && at_ + 2 != end_ && at_[2] == '\n' ? 3 : joins ? 2 : 1;
    }
    if (at_ == end_) return;
    at_ += *at_ == '\r' && at_ + 1 != end_ && at_[1] == '\n' ? 2 : 1;
}

bool Scanner::lineEnds() { return !skipBlanks(); }

std::string_view Scanner::wordAnywhere(char comment) {
    while (true) {
        if (!skipBlanks()) {
            if (at_ == end_) {
                token_ = at_;
                return {};
            }
            skipLine();
        } else if (*at_ == comment) {
            skipLine();
        } else {
            return word();
        }
    }
}

template <class Real>
Real Scanner::real(std::string_view word, std::string_view field, Real limit) {
    Real value = 0;
    if (word.empty()) refuse(fmt::format("{} is missing", field));
    if (!parseReal(word, value)) refuse(fmt::format("{} '{}' is not a number", field, printable(word, 40)));
    if (!(std::abs(value) <= limit)) {
        if (std::isnan(value)) refuse(fmt::format("{} is NaN", field));
        // Infinities written as digits are overflows, and refused as too large.
        if (std::isinf(value) && word.find_first_of("iI") != std::string_view::npos) refuse(fmt::format("{} is infinite", field));
        refuse(fmt::format("{} is {}; the largest magnitude is {:g}", field, printable(word, 40), limit));
    }
    return value;
}

float Scanner::number(std::string_view word, std::string_view field, float limit) { return real(word, field, limit); }
double Scanner::coordinate(std::string_view word, std::string_view field) { return real(word, field, double(kMaxCoordinate)); }

int64_t Scanner::integer(std::string_view word, std::string_view field) {
    int64_t value = 0;
    if (word.empty()) refuse(fmt::format("{} is missing", field));
    if (!parseInteger(word, value)) refuse(fmt::format("{} '{}' is not an integer", field, printable(word, 40)));
    return value;
}

std::string Scanner::locationAt(const char* at) const {
    size_t line = 1;
    const char* lineStart = text_.data();
    for (const char* p = text_.data(); p < at; ++p)
        if (*p == '\n' || (*p == '\r' && !(p + 1 != end_ && p[1] == '\n'))) {
            ++line;
            lineStart = p + 1;
        }
    return locationOfLine(file_, line, size_t(at - lineStart) + 1);
}

void Scanner::refuse(std::string_view message) const { throw inputError(location(), std::string(message)); }

}  // namespace plumb
