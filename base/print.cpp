#include "base/print.h"

#include <ostream>

namespace springdrive {

void print_checked(std::ostream &out, fmt::string_view format, fmt::format_args values) {
    out << fmt::vformat(format, values);
}

} // namespace springdrive
