#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Fails on a unit that relies on another's includes: each name of the C and C++ libraries, of POSIX, fmt and GLM that a file uses must come from
an #include that stands in the file itself, or in the header of its own stem (`fill_cpu.cpp` and `fill_gpu.cpp` may rely on `fill.h`).

What a library's headers include of each other differs from version to version, so a compiler finds only what its own library lacks. The tables below say
instead which headers the standard names for a name. A name of `std` that they do not know is a fault too.

usage: include_lint.py [--fix] [ROOT]    exit 0: clean; 1: one line for each fault on stdout. --fix: writes the first header that gives the name into the file
       include_lint.py --self-test       exit 1 when a missing include goes unnoticed
"""
import os
import re
import sys
import tempfile

TOPS = ("host", "pipeline", "tests", "toolchain", "examples")
SOURCE = (".h", ".hpp", ".cpp", ".c", ".cc")

# Header -> names of std that it gives. A name may stand at several headers; --fix takes the first in this order.
STD = {
    "algorithm": """adjacent_find all_of any_of binary_search clamp copy copy_backward copy_if copy_n count count_if equal equal_range fill fill_n find find_end
        find_first_of find_if find_if_not for_each for_each_n generate generate_n includes inplace_merge is_heap is_partitioned is_permutation is_sorted
        is_sorted_until iter_swap lexicographical_compare lexicographical_compare_three_way lower_bound make_heap max max_element merge min min_element minmax
        minmax_element mismatch next_permutation none_of nth_element partial_sort partial_sort_copy partition partition_copy partition_point pop_heap
        prev_permutation push_heap remove remove_copy remove_copy_if remove_if replace replace_copy replace_if reverse reverse_copy rotate rotate_copy sample
        search search_n set_difference set_intersection set_symmetric_difference set_union shift_left shift_right shuffle sort sort_heap stable_partition
        stable_sort swap_ranges transform unique unique_copy upper_bound
        ranges::all_of ranges::any_of ranges::copy ranges::count ranges::count_if ranges::equal ranges::fill ranges::find ranges::find_if ranges::for_each
        ranges::max ranges::max_element ranges::min ranges::min_element ranges::minmax ranges::none_of ranges::reverse ranges::sort ranges::stable_sort
        ranges::transform ranges::unique ranges::lower_bound ranges::upper_bound ranges::binary_search ranges::is_sorted""",
    "any": "any any_cast make_any bad_any_cast",
    "array": "array to_array",
    "atomic": """atomic atomic_flag atomic_ref atomic_thread_fence atomic_signal_fence memory_order memory_order_relaxed memory_order_acquire memory_order_release
        memory_order_acq_rel memory_order_seq_cst""",
    "barrier": "barrier",
    "bit": "bit_cast bit_ceil bit_floor bit_width byteswap countl_one countl_zero countr_one countr_zero endian has_single_bit popcount rotl rotr",
    "bitset": "bitset",
    "cctype": "isalnum isalpha isblank iscntrl isdigit isgraph islower isprint ispunct isspace isupper isxdigit tolower toupper",
    "cfenv": "fenv_t feclearexcept fegetenv fegetround feholdexcept feraiseexcept fesetenv fesetround fetestexcept feupdateenv",
    "charconv": "from_chars to_chars from_chars_result to_chars_result chars_format",
    "chrono": "chrono",
    "cinttypes": "imaxabs strtoimax strtoumax",
    "clocale": "setlocale localeconv",
    "cmath": """abs acos acosh acosf asin asinf asinh atan atan2 atan2f atanf atanh cbrt cbrtf ceil ceilf copysign copysignf cos cosf cosh erf erfc exp exp2 exp2f expf
        expm1 fabs fabsf fdim floor floorf fma fmaf fmax fmaxf fmin fminf fmod fmodf fpclassify frexp hypot hypotf ilogb ilogbf isfinite isgreater isinf isless isnan
        isnormal isunordered ldexp ldexpf lerp lgamma llrint llround log log10 log10f log1p log2 log2f logb logf lrint lrintf lround lroundf modf nan nanf nanl
        nearbyint nearbyintf nextafter nextafterf nexttoward pow powf remainder remquo rint rintf round roundf scalbln scalbn scalbnf signbit sin sinf sinh sqrt
        sqrtf sqrtl tan tanf tanh tgamma trunc truncf float_t double_t""",
    "complex": "complex",
    "concepts": """same_as derived_from convertible_to integral signed_integral unsigned_integral floating_point assignable_from swappable destructible
        constructible_from default_initializable move_constructible copy_constructible equality_comparable totally_ordered movable copyable semiregular
        regular invocable regular_invocable predicate""",
    "condition_variable": "condition_variable condition_variable_any cv_status",
    "csetjmp": "jmp_buf longjmp",
    "csignal": "signal raise sig_atomic_t",
    "cstdarg": "va_list",
    "cstddef": "byte to_integer max_align_t nullptr_t ptrdiff_t size_t",
    "cstdint": """int8_t int16_t int32_t int64_t uint8_t uint16_t uint32_t uint64_t intmax_t uintmax_t intptr_t uintptr_t int_fast8_t int_fast16_t int_fast32_t
        int_fast64_t uint_fast8_t uint_fast16_t uint_fast32_t uint_fast64_t int_least8_t int_least16_t int_least32_t int_least64_t uint_least8_t
        uint_least16_t uint_least32_t uint_least64_t""",
    "cstdio": """FILE fclose feof ferror fflush fgetc fgets fileno fopen fpos_t fprintf fputc fputs fread freopen fscanf fseek fsetpos ftell fwrite getc getchar perror
        printf putc putchar puts remove rename rewind scanf setbuf setvbuf size_t snprintf sprintf sscanf tmpfile tmpnam ungetc vfprintf vprintf vsnprintf
        vsprintf""",
    "cstdlib": """_Exit abort abs aligned_alloc at_quick_exit atexit atof atoi atol atoll bsearch calloc div exit free getenv labs llabs ldiv malloc qsort quick_exit
        rand realloc size_t srand strtod strtof strtol strtold strtoll strtoul strtoull system""",
    "cstring": """memchr memcmp memcpy memmove memset size_t strcat strchr strcmp strcoll strcpy strcspn strerror strlen strncat strncmp strncpy strpbrk strrchr strspn
        strstr strtok""",
    "ctime": "asctime clock clock_t ctime difftime gmtime localtime mktime size_t strftime time time_t timespec tm",
    "deque": "deque",
    "exception": """bad_exception current_exception exception exception_ptr make_exception_ptr nested_exception rethrow_exception rethrow_if_nested set_terminate
        terminate throw_with_nested uncaught_exceptions""",
    "execution": "execution",
    "expected": "expected unexpected",
    "filesystem": "filesystem",
    "fstream": "basic_fstream basic_ifstream basic_ofstream filebuf fstream ifstream ofstream",
    "functional": """bind bind_front bit_and bit_or bit_xor boyer_moore_searcher cref divides equal_to function greater greater_equal hash identity invoke less
        less_equal logical_and logical_not logical_or mem_fn minus modulus multiplies negate not_equal_to not_fn plus ref reference_wrapper placeholders""",
    "future": "async future future_error future_status launch packaged_task promise shared_future",
    "initializer_list": "initializer_list",
    "iomanip": "get_time put_time quoted resetiosflags setbase setfill setiosflags setprecision setw",
    "ios": """boolalpha dec defaultfloat fixed hex hexfloat ios ios_base left noboolalpha noshowbase noshowpos nouppercase oct right scientific showbase showpoint
        showpos skipws streamoff streampos streamsize uppercase""",
    "iostream": "cerr cin clog cout wcerr wcout",
    "istream": "basic_istream iostream istream ws",
    "iterator": """advance back_insert_iterator back_inserter bidirectional_iterator_tag contiguous_iterator_tag default_sentinel distance forward_iterator
        forward_iterator_tag front_inserter input_iterator_tag inserter istream_iterator istreambuf_iterator iter_value_t iterator_traits make_move_iterator
        move_iterator next ostream_iterator ostreambuf_iterator output_iterator prev random_access_iterator random_access_iterator_tag reverse_iterator""",
    "latch": "latch",
    "limits": "float_denorm_style numeric_limits",
    "list": "list",
    "locale": "locale codecvt ctype numpunct moneypunct use_facet has_facet time_get time_put",
    "map": "map multimap",
    "memory": """addressof align allocate_shared allocator allocator_traits assume_aligned const_pointer_cast construct_at default_delete destroy destroy_at
        destroy_n dynamic_pointer_cast enable_shared_from_this make_shared make_shared_for_overwrite make_unique make_unique_for_overwrite pointer_traits
        reinterpret_pointer_cast shared_ptr static_pointer_cast to_address uninitialized_copy uninitialized_default_construct uninitialized_fill
        uninitialized_move unique_ptr weak_ptr""",
    "memory_resource": "pmr",
    "mutex": "call_once defer_lock lock lock_guard mutex once_flag recursive_mutex scoped_lock timed_mutex try_lock unique_lock adopt_lock try_to_lock",
    "new": "align_val_t bad_alloc bad_array_new_length get_new_handler hardware_destructive_interference_size launder new_handler nothrow nothrow_t set_new_handler",
    "numbers": "numbers",
    "numeric": """accumulate adjacent_difference exclusive_scan gcd inclusive_scan inner_product iota lcm midpoint partial_sum reduce transform_exclusive_scan
        transform_inclusive_scan transform_reduce""",
    "optional": "bad_optional_access make_optional nullopt nullopt_t optional",
    "ostream": "basic_ostream endl ends flush ostream",
    "queue": "priority_queue queue",
    "random": """bernoulli_distribution binomial_distribution default_random_engine discrete_distribution exponential_distribution gamma_distribution
        geometric_distribution linear_congruential_engine lognormal_distribution mersenne_twister_engine minstd_rand minstd_rand0 mt19937 mt19937_64
        normal_distribution piecewise_constant_distribution poisson_distribution random_device seed_seq uniform_int_distribution uniform_real_distribution
        weibull_distribution""",
    "ranges": "views ranges::begin ranges::end ranges::size ranges::range ranges::view ranges::iota_view ranges::subrange ranges::empty ranges::data",
    "ratio": "atto centi deca deci exa femto giga hecto kilo mega micro milli nano peta pico ratio tera",
    "regex": "cmatch regex regex_error regex_iterator regex_match regex_replace regex_search smatch sregex_iterator sregex_token_iterator",
    "semaphore": "binary_semaphore counting_semaphore",
    "set": "multiset set",
    "shared_mutex": "shared_lock shared_mutex shared_timed_mutex",
    "source_location": "source_location",
    "span": "as_bytes as_writable_bytes dynamic_extent span",
    "sstream": "basic_ostringstream istringstream ostringstream stringbuf stringstream",
    "stack": "stack",
    "stdexcept": "domain_error invalid_argument length_error logic_error out_of_range overflow_error range_error runtime_error underflow_error",
    "stop_token": "stop_callback stop_source stop_token",
    "streambuf": "basic_streambuf streambuf",
    "string": """basic_string char_traits getline stod stof stoi stol stold stoll stoul stoull string to_string to_wstring u16string u32string u8string wstring""",
    "string_view": "basic_string_view string_view u16string_view u32string_view u8string_view wstring_view",
    "syncstream": "osyncstream",
    "system_error": "errc error_category error_code error_condition generic_category make_error_code make_error_condition system_category system_error",
    "thread": "jthread this_thread thread",
    "tuple": "apply forward_as_tuple ignore make_from_tuple make_tuple tie tuple tuple_cat",
    "type_traits": """add_const_t add_lvalue_reference_t add_pointer_t aligned_storage_t bool_constant common_type common_type_t conditional conditional_t decay decay_t
        enable_if enable_if_t false_type integral_constant invoke_result invoke_result_t is_arithmetic is_arithmetic_v is_array_v is_base_of_v is_class_v
        is_const_v is_constant_evaluated is_constructible_v is_convertible is_convertible_v is_copy_constructible_v is_empty_v is_enum is_enum_v
        is_floating_point is_floating_point_v is_function_v is_integral is_integral_v is_invocable is_invocable_r_v is_invocable_v is_lvalue_reference_v
        is_nothrow_move_constructible_v is_null_pointer_v is_pointer is_pointer_v is_reference_v is_rvalue_reference_v is_same is_same_v is_scalar_v is_signed
        is_signed_v is_standard_layout is_standard_layout_v is_trivial_v is_trivially_copyable is_trivially_copyable_v is_unsigned is_unsigned_v is_void
        is_void_v make_signed_t make_unsigned make_unsigned_t remove_const_t remove_cv_t remove_cvref remove_cvref_t remove_extent_t remove_pointer_t
        remove_reference remove_reference_t true_type type_identity type_identity_t underlying_type underlying_type_t void_t""",
    "typeindex": "type_index",
    "typeinfo": "bad_cast bad_typeid type_info",
    "unordered_map": "unordered_map unordered_multimap",
    "unordered_set": "unordered_multiset unordered_set",
    "utility": """as_const cmp_equal cmp_greater cmp_greater_equal cmp_less cmp_less_equal cmp_not_equal declval exchange forward in_range in_place in_place_t
        index_sequence index_sequence_for integer_sequence make_index_sequence make_integer_sequence make_pair move move_if_noexcept pair
        piecewise_construct swap to_underlying tuple_element tuple_size tuple_size_v unreachable""",
    "valarray": "valarray",
    "variant": "get_if holds_alternative in_place_index in_place_type monostate variant variant_alternative_t variant_size_v visit bad_variant_access",
    "vector": "vector",
    "version": "",
}
# Names that the standard gives with each of many headers; the containers hold what walks over them.
CONTAINERS = "array deque list map set span string string_view unordered_map unordered_set vector iterator".split()
SHARED = {
    **{name: CONTAINERS for name in "begin cbegin cend crbegin crend data empty end rbegin rend size ssize".split()},
    "erase": "string vector deque list".split(), "erase_if": "vector string deque list map set unordered_map unordered_set".split(),
    "get": "tuple array utility variant".split(),
    "swap": ["utility"] + CONTAINERS,
    "hash": ["functional", "string", "string_view", "optional", "memory", "variant"],
    # The standard has these headers include <ios> or <initializer_list>, or give the type with their own.
    **{name: ["ios", "fstream", "sstream", "iostream", "istream", "ostream"] for name in STD["ios"].split()},
    "initializer_list": "initializer_list utility string vector map set array deque list unordered_map unordered_set".split(),
    **{name: ["ostream", "iostream", "sstream", "fstream"] for name in "ostream basic_ostream endl flush".split()},
    **{name: ["istream", "iostream", "sstream", "fstream"] for name in "istream basic_istream".split()},
    **{name: ["ratio", "chrono"] for name in STD["ratio"].split()},
    **{name: ["system_error", "charconv"] if name == "errc" else ["system_error", "filesystem"] for name in ("errc", "error_code")},
    "exception": ["exception", "stdexcept", "new", "system_error"],
}
# What stands without std:: in our sources. Every header of the C++ library that counts something gives size_t.
CPP_COUNTS = ["cstddef", "cstdio", "cstdlib", "cstring", "ctime"] + CONTAINERS + ["algorithm", "bit", "functional", "memory", "numeric", "utility", "optional"]
PLAIN = {**{name: ["cstdint"] for name in STD["cstdint"].split()},
         "size_t": CPP_COUNTS, "ptrdiff_t": ["cstddef"] + CONTAINERS, "offsetof": ["cstddef"], "assert": ["cassert"], "errno": ["cerrno"], "va_start": ["cstdarg"],
         **{name: ["cmath"] for name in "INFINITY NAN HUGE_VAL M_PI FP_NAN FP_SUBNORMAL FP_ZERO".split()},
         **{name: ["cstdio"] for name in "stdin stdout stderr EOF SEEK_SET SEEK_END SEEK_CUR FILE".split()},
         **{name: ["cstdlib"] for name in "EXIT_SUCCESS EXIT_FAILURE".split()},
         **{name: ["cstdlib"] for name in "setenv unsetenv mkdtemp mkstemp realpath getloadavg".split()},
         **{name: ["cfenv"] for name in "FE_TONEAREST FE_DOWNWARD FE_UPWARD FE_TOWARDZERO FE_INEXACT FE_DFL_ENV FE_ALL_EXCEPT".split()},
         **{name: ["cstdio"] for name in "fileno fdopen open_memstream dprintf popen pclose".split()},
         **{name: ["unistd.h"] for name in """access close dup dup2 fsync fdatasync ftruncate getpid getppid isatty link lseek pipe pipe2 read readlink rmdir symlink
            sysconf unlink usleep write STDIN_FILENO STDOUT_FILENO STDERR_FILENO""".split()},
         **{name: ["fcntl.h"] for name in """fcntl open openat posix_fallocate O_RDONLY O_WRONLY O_RDWR O_CREAT O_EXCL O_TRUNC O_APPEND O_CLOEXEC O_NONBLOCK O_NOCTTY
            O_DIRECTORY O_NOFOLLOW O_TMPFILE F_GETFL F_SETFL AT_FDCWD""".split()},
         **{name: ["sys/stat.h"] for name in "chmod fchmod fstat lstat mkdir stat umask S_ISREG S_ISDIR S_ISFIFO S_ISSOCK S_ISCHR S_ISLNK".split()},
         **{name: ["sys/mman.h"] for name in "mmap munmap madvise mlock MAP_FAILED MAP_PRIVATE PROT_READ PROT_WRITE".split()},
         **{name: ["sys/resource.h"] for name in "getrlimit setrlimit getrusage rlimit rusage RLIMIT_FSIZE RLIMIT_AS RUSAGE_SELF".split()},
         **{name: ["sys/wait.h"] for name in "waitpid WIFEXITED WEXITSTATUS WIFSIGNALED WTERMSIG".split()},
         **{name: ["csignal", "signal.h"] for name in """sigaction sigemptyset sigprocmask SIGINT SIGTERM SIGPIPE SIGXFSZ SIGHUP SIGKILL SIGALRM SIGCHLD SIG_DFL
            SIG_IGN SIG_ERR SA_RESETHAND SA_RESTART""".split()},
         **{name: ["dlfcn.h"] for name in "dlopen dlsym dlclose dlerror RTLD_NOW RTLD_LAZY RTLD_LOCAL RTLD_GLOBAL RTLD_NODELETE RTLD_DEFAULT RTLD_NEXT".split()},
         **{name: ["poll.h"] for name in "poll pollfd POLLIN POLLOUT".split()}}
# Patterns of plain names: limits and error numbers.
PATTERNS = [(re.compile(r"U?INT(?:8|16|32|64|PTR|MAX|_LEAST\d+|_FAST\d+)_(?:MAX|MIN)$|SIZE_MAX$|U?INT\d+_C$"), ["cstdint"]),
            (re.compile(r"(?:S?CHAR|U?CHAR|SHRT|USHRT|INT|UINT|LONG|ULONG|LLONG|ULLONG)_(?:MAX|MIN)$|CHAR_BIT$"), ["climits"]),
            (re.compile(r"(?:FLT|DBL|LDBL)_\w+$"), ["cfloat"]),
            (re.compile(r"E(?:ACCES|AGAIN|BADF|BUSY|CHILD|EXIST|FBIG|INTR|INVAL|IO|ISDIR|LOOP|MFILE|NAMETOOLONG|NFILE|NODEV|NOENT|NOMEM|NOSPC|NOTDIR|NOTEMPTY|NOTSUP|"
                        r"NXIO|OPNOTSUPP|OVERFLOW|PERM|PIPE|RANGE|ROFS|TXTBSY|WOULDBLOCK|XDEV|DQUOT)$"), ["cerrno"]),
            (re.compile(r"PRI[diouxX]\d+$"), ["cinttypes"])]
# A function is one only where it is called, a type or macro wherever it stands; members (`file.read(...)`, `x->close()`) and names of other scopes are none.
CALLED = set("""access close dup dup2 fsync fdatasync ftruncate getpid getppid isatty link lseek pipe pipe2 read readlink rmdir symlink sysconf unlink usleep write
    fcntl open openat posix_fallocate chmod fchmod fstat lstat mkdir stat umask mmap munmap madvise mlock getrlimit setrlimit getrusage waitpid sigaction sigemptyset
    sigprocmask dlopen dlsym dlclose dlerror poll setenv unsetenv mkdtemp mkstemp realpath getloadavg fileno fdopen open_memstream dprintf popen pclose assert
    va_start offsetof""".split())
# Functions whose names are everyday words count only as `::name(`.
QUALIFIED = set("access close dup link open pipe poll read stat write fcntl mkdir chmod symlink rmdir".split())
FMT = {**{name: ["fmt/format.h", "fmt/core.h"] for name in "format print format_to format_to_n formatted_size runtime string_view vformat format_error".split()},
       "join": ["fmt/ranges.h"], "ptr": ["fmt/format.h"], "memory_buffer": ["fmt/format.h"], "to_string": ["fmt/format.h"], "group_digits": ["fmt/format.h"],
       "gmtime": ["fmt/chrono.h"], "localtime": ["fmt/chrono.h"], "formatter": ["fmt/core.h", "fmt/format.h"]}
FMT_INCLUDES = {"fmt/ranges.h": ["fmt/format.h", "fmt/core.h"], "fmt/chrono.h": ["fmt/format.h", "fmt/core.h"], "fmt/format.h": ["fmt/core.h"]}

# C's own spelling of a header gives the names as well.
C_NAMES = {f"c{name}": f"{name}.h" for name in "assert ctype errno fenv float inttypes limits locale math setjmp signal stdarg stddef stdint stdio stdlib string time".split()}
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*([<"])([^>"]+)[>"]', re.M)
NOISE = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'', re.S)


def tables():
    std = {}
    for header, names in STD.items():
        for name in names.split():
            std.setdefault(name, []).append(header)
    for name, headers in SHARED.items():
        std[name] = headers + [header for header in std.get(name, []) if header not in headers]
    return std


NAMES = tables()


def blanked(text):
    """The text without comments and literals, at the same lines. A digit separator is no literal."""
    text = re.sub(r"(?<=[0-9a-fA-F])'(?=[0-9a-fA-F])", "0", text)
    return NOISE.sub(lambda match: re.sub(r"[^\n]", " ", match.group(0)), text)


def conditional_lines(text):
    """Lines between #if and #endif, but for those of an include guard."""
    open_, inside = [], set()
    for number, line in enumerate(text.split("\n"), 1):
        m = re.match(r"[ \t]*#[ \t]*(if|endif)(ndef[ \t]+PLUMB_\w+_H$)?", line)
        if m and m.group(1) == "if":
            open_.append(not m.group(2))
        elif m and open_:
            open_.pop()
        if any(open_):
            inside.add(number)
    return inside


def line_of(text, at):
    return text.count("\n", 0, at) + 1


def uses(text):
    """{(shown name, headers that give it): first line}, of what stands outside #if and of what stands inside"""
    conditional = conditional_lines(text)
    always, sometimes = {}, {}

    def use(name, headers, at):
        line = line_of(text, at)
        (sometimes if line in conditional else always).setdefault((name, tuple(headers)), line)
    for m in re.finditer(r"(?<![\w:])(?:::)?std::((?:\w+::)*\w+)", text):
        words = m.group(1).split("::")
        name = "::".join(words[:2]) if words[0] == "ranges" else words[0]
        use(f"std::{name}", NAMES.get(name, ()), m.start())
    for m in re.finditer(r"(?<![\w:])fmt::(\w+)", text):
        use(f"fmt::{m.group(1)}", FMT.get(m.group(1), ()), m.start())
    for m in re.finditer(r"(?<![\w:])glm::\w+", text):
        use("glm::", ["glm/"], m.start())
    declared = set(re.findall(r"#[ \t]*define[ \t]+(\w+)", text))
    for m in re.finditer(r"(?<![\w:.])(?<!->)(::)?\b([A-Za-z_]\w*)\b([ \t]*\()?", text):
        scope, name, call = m.groups()
        if name in declared:
            continue
        headers = PLAIN.get(name) or next((headers for pattern, headers in PATTERNS if pattern.match(name)), None)
        if headers is None or name in CALLED and not call or name in QUALIFIED and not scope:
            continue
        use(name, headers, m.start())
    return always, sometimes


def includes(text, conditional=frozenset()):
    """Names of what a text includes outside the lines given; C's spelling of a header counts as C++'s."""
    given = set()
    for m in INCLUDE.finditer(text):
        if line_of(text, m.start()) in conditional:
            continue
        name = m.group(2)
        given.add(name)
        given.update(cpp for cpp, c in C_NAMES.items() if c == name)
        given.update(FMT_INCLUDES.get(name, ()))
        if name.startswith("glm/"):
            given.add("glm/")
    return given


def own_header(root, path):
    """The header of a source's stem, also without its side: fill_cpu.cpp -> fill.h. It must be one that the source includes."""
    base, extension = os.path.splitext(path)
    if extension in (".h", ".hpp"):
        return None
    for stem in (base, re.sub(r"_(cpu|gpu)$", "", base)):
        for end in (".h", ".hpp"):
            if os.path.isfile(os.path.join(root, stem + end)):
                return stem + end
    return None


def sources(root):
    for top in TOPS:
        for folder, folders, files in os.walk(os.path.join(root, top)):
            folders.sort()
            for name in sorted(files):
                if name.endswith(SOURCE):
                    yield os.path.relpath(os.path.join(folder, name), root)


def read(root, path):
    with open(os.path.join(root, path), encoding="utf-8") as f:
        return f.read()


def missing(root, path):
    """[(line, name, headers that give it)] of what a file uses and neither it nor its own header includes."""
    text = read(root, path)
    given = includes(text, conditional_lines(text))
    own = own_header(root, path)
    of_own = includes(read(root, own)) if own and own in given else set()
    always, sometimes = uses(blanked(text))
    return sorted([(line, name, headers) for (name, headers), line in always.items() if not (given | of_own).intersection(headers)] +
                  [(line, name, headers) for (name, headers), line in sometimes.items() if not (includes(text) | of_own).intersection(headers)])


def mended(text, headers):
    """The text with the headers in the block of <...> includes, in its order where it has one, else behind the last include."""
    for header in sorted(headers):
        line = f"#include <{header}>"
        conditional = conditional_lines(text)
        after = [m for m in INCLUDE.finditer(text) if line_of(text, m.start()) not in conditional]
        at = [(m.start(), m.group(2)) for m in after if m.group(1) == "<"]
        place = next((start for start, name in at if name > header), None)
        if place is not None:
            text = text[:place] + line + "\n" + text[place:]
        elif after:
            end = text.index("\n", after[-1].start()) + 1
            text = text[:end] + ("" if after[-1].group(1) == "<" else "\n") + line + "\n" + text[end:]
        else:
            once = re.search(r"^#pragma once\n|^#define PLUMB_\w+_H\n", text, re.M)
            comments = re.match(r"(?://[^\n]*\n)*", text).end()
            end = once.end() if once else comments
            text = text[:end] + ("\n" if once else "") + line + "\n" + text[end:]
    return text


def check(root, fix=False):
    count, faults = 0, []
    for path in sources(root):
        count += 1
        lacking = missing(root, path)
        wanted = set()
        for line, name, headers in lacking:
            if not headers:
                faults.append(f"{path}:{line}: include_lint.py does not know {name}: add it to the table of the header that gives it")
            elif fix:
                wanted.add("glm/glm.hpp" if headers == ("glm/",) else headers[0])
            else:
                shown = "<glm/glm.hpp>" if headers == ("glm/",) else " or ".join(f"<{header}>" for header in headers[:3])
                faults.append(f"{path}:{line}: {name} needs {shown}, which neither this file nor its own header includes")
        if wanted:
            text = mended(read(root, path), wanted)
            with open(os.path.join(root, path), "w", encoding="utf-8") as f:
                f.write(text)
    return count, faults


def self_test():
    header = "#pragma once\n\n#include <cstdint>\n#include <vector>\n"
    clean = {
        "host/a.h": header + "std::vector<uint32_t> f();\n",
        "host/a.cpp": '#include "host/a.h"\n\n#include <algorithm>\n\nstd::vector<uint32_t> f() { return {std::max(1u, 2u)}; }\n',
        "host/a_gpu.cpp": '#include "host/a.h"\nuint32_t g() { return uint32_t(f().size()); }\n',
        "pipeline/b.cpp": '#include <stdint.h>\n#include <fstream>\nint64_t h(std::ifstream& in, Door& door) {\n'
                          '#ifdef PLUMB_SPEAK\n#include <list>\nstatic std::list<int> spoken;\n#endif\n    // std::string is only spoken of, and so is std::sort\n    const auto text = "std::map<uint8_t> EINTR";\n    in.read(0, 0), door->close(1);\n'
                          "    const char quote = '\"'; const int million = 1'000'000;\n    return read(quote, million);\n}\n",
    }
    lacking = {
        "an algorithm": "int x = std::sort(a, b);", "an integer type": "uint16_t x;", "an integer type of std": "std::uint16_t x;", "a container": "std::map<int, int> x;",
        "a string": "std::string x;", "a pair": "std::pair<int, int> x;", "a move": "auto x = std::move(y);", "an exchange": "auto x = std::exchange(y, 1);",
        "limits": "auto x = std::numeric_limits<int>::max();", "an array": "std::array<int, 2> x;", "a function": "std::function<void()> x;",
        "bytes copied": "void x() { std::memcpy(a, b, 1); }", "an optional": "std::optional<int> x;", "a mathematical function": "auto x = std::sqrt(2.0);",
        "memory": "auto x = std::make_unique<int>(1);", "a limit of C": "int x = INT_MAX;", "a limit of float": "float x = FLT_MAX;", "infinity": "float x = INFINITY;",
        "an error number": "bool x = y == ENOENT;", "errno": "int x = errno;", "a POSIX function": "int x = ::close(1);", "a flag of open": "int x = O_RDONLY;",
        "a signal": "int x = SIGTERM;", "a stream of C": "auto x = stderr;", "a range": "bool x = std::ranges::equal(a, b);", "GLM": "glm::vec3 x;", "fmt": "auto x = fmt::join(a, b);",
        "a name after a digit separator": "int x = 1'000; std::list<int> y; char z = 'z';", "a name after a raw string": 'auto x = R"(")"; std::list<int> y;',
        "an unknown name of std": "std::teleport x;", "an unknown name of fmt": "auto x = fmt::teleport(1);",
        "an include under a condition": "#ifdef PLUMB_X\n#include <list>\n#endif\nstd::list<int> x;",
        "what another header includes": '#include "host/a.h"\nstd::vector<int> x;',
    }
    wrong = []
    for claim, text in [("clean", None)] + list(lacking.items()):
        with tempfile.TemporaryDirectory() as root:
            for path, content in {**clean, **({"pipeline/c.cpp": text + "\n"} if text else {})}.items():
                os.makedirs(os.path.dirname(os.path.join(root, path)), exist_ok=True)
                with open(os.path.join(root, path), "w", encoding="utf-8") as f:
                    f.write(content)
            faults = check(root)[1]
            if bool(faults) != (text is not None):
                wrong.append(f"{claim}: {faults or 'unnoticed'}")
            check(root, fix=True)
            left = check(root)[1]
            if left and "unknown" not in claim:
                wrong.append(f"{claim}: --fix leaves {left}")
            if text and not read(root, "pipeline/c.cpp").endswith(text.splitlines()[-1] + "\n"):
                wrong.append(f"{claim}: --fix changes more than includes")
    # The clean files need each of their includes.
    for path, text in clean.items():
        for m in INCLUDE.finditer(text):
            with tempfile.TemporaryDirectory() as root:
                for other, content in clean.items():
                    os.makedirs(os.path.dirname(os.path.join(root, other)), exist_ok=True)
                    with open(os.path.join(root, other), "w", encoding="utf-8") as f:
                        f.write(content.replace(m.group(0), "", 1) if other == path else content)
                if not check(root)[1]:
                    wrong.append(f"{path} without {m.group(2)}: unnoticed")
    for line in wrong:
        print(line)
    print(f"include_lint --self-test: {len(lacking)} missing includes, {len(wrong)} wrong answers")
    return 1 if wrong else 0


def main():
    arguments = sys.argv[1:]
    if arguments == ["--self-test"]:
        return self_test()
    fix = "--fix" in arguments
    places = [word for word in arguments if word != "--fix"]
    root = places[0] if places else os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
    count, faults = check(root, fix)
    for fault in faults:
        print(fault)
    print(f"include_lint: {count} files, {len(faults)} names without an include of their own")
    return 1 if faults or count == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
