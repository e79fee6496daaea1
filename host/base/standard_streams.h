// Descriptors 0 to 2 as a program may find them: closed by its caller, or with a reader that has gone.
#pragma once

namespace raycube::base {

/// Takes the numbers 0, 1 and 2 where the caller left them closed, so that no file opened later gets one of
/// them and with it what is printed. They stay as unusable as they were: reading 0 and writing 1 or 2 fail.
/// To be called first thing in main().
void claim_standard_descriptors() noexcept;

/// True when descriptor 1 is a pipe or socket that nobody reads any more.
bool stdout_reader_is_gone() noexcept;

}  // namespace raycube::base
