// SPDX-License-Identifier: Apache-2.0
//! Macros that C code meets wherever it is: what a program calls so is replaced before the compiler sees it.

/// Those of the headers that bodies have without asking for them, and of GNU C itself.
#[rustfmt::skip]
const NAMES: [&str; 249] = [
    "AIO_PRIO_DELTA_MAX", "BC_BASE_MAX", "BC_DIM_MAX", "BC_SCALE_MAX", "BC_STRING_MAX", "BIG_ENDIAN", "BILLION",
    "BUFSIZ", "BYTE_ORDER", "CHARCLASS_NAME_MAX", "CHAR_BIT", "CHAR_MAX", "CHAR_MIN", "CLOCKS_PER_SEC",
    "COLL_WEIGHTS_MAX", "DELAYTIMER_MAX", "E2BIG", "EACCES", "EADDRINUSE", "EADDRNOTAVAIL", "EADV", "EAFNOSUPPORT",
    "EAGAIN", "EALREADY", "EBADE", "EBADF", "EBADFD", "EBADMSG", "EBADR", "EBADRQC", "EBADSLT", "EBFONT", "EBUSY",
    "ECANCELED", "ECHILD", "ECHRNG", "ECOMM", "ECONNABORTED", "ECONNREFUSED", "ECONNRESET", "EDEADLK", "EDEADLOCK",
    "EDESTADDRREQ", "EDOM", "EDOTDOT", "EDQUOT", "EEXIST", "EFAULT", "EFBIG", "EHOSTDOWN", "EHOSTUNREACH",
    "EHWPOISON", "EIDRM", "EILSEQ", "EINPROGRESS", "EINTR", "EINVAL", "EIO", "EISCONN", "EISDIR", "EISNAM",
    "EKEYEXPIRED", "EKEYREJECTED", "EKEYREVOKED", "EL2HLT", "EL2NSYNC", "EL3HLT", "EL3RST", "ELIBACC", "ELIBBAD",
    "ELIBEXEC", "ELIBMAX", "ELIBSCN", "ELNRNG", "ELOOP", "EMEDIUMTYPE", "EMFILE", "EMLINK", "EMSGSIZE", "EMULTIHOP",
    "ENAMETOOLONG", "ENAVAIL", "ENETDOWN", "ENETRESET", "ENETUNREACH", "ENFILE", "ENOANO", "ENOBUFS", "ENOCSI",
    "ENODATA", "ENODEV", "ENOENT", "ENOEXEC", "ENOKEY", "ENOLCK", "ENOLINK", "ENOMEDIUM", "ENOMEM", "ENOMSG",
    "ENONET", "ENOPKG", "ENOPROTOOPT", "ENOSPC", "ENOSR", "ENOSTR", "ENOSYS", "ENOTBLK", "ENOTCONN", "ENOTDIR",
    "ENOTEMPTY", "ENOTNAM", "ENOTRECOVERABLE", "ENOTSOCK", "ENOTSUP", "ENOTTY", "ENOTUNIQ", "ENXIO", "EOF",
    "EOPNOTSUPP", "EOVERFLOW", "EOWNERDEAD", "EPERM", "EPFNOSUPPORT", "EPIPE", "EPROTO", "EPROTONOSUPPORT",
    "EPROTOTYPE", "ERANGE", "EREMCHG", "EREMOTE", "EREMOTEIO", "ERESTART", "ERFKILL", "EROFS", "ESHUTDOWN",
    "ESOCKTNOSUPPORT", "ESPIPE", "ESRCH", "ESRMNT", "ESTALE", "ESTRPIPE", "ETIME", "ETIMEDOUT", "ETOOMANYREFS",
    "ETXTBSY", "EUCLEAN", "EUNATCH", "EUSERS", "EWOULDBLOCK", "EXDEV", "EXFULL", "EXIT_FAILURE", "EXIT_SUCCESS",
    "EXPR_NEST_MAX", "FD_SETSIZE", "FILENAME_MAX", "FOPEN_MAX", "FOREVER", "FOREVER_MICROSTEP", "FOREVER_TAG",
    "FOREVER_TAG_INITIALIZER", "HOST_NAME_MAX", "INFINITY", "INT16_MAX", "INT16_MIN", "INT32_MAX", "INT32_MIN",
    "INT64_MAX", "INT64_MIN", "INT8_MAX", "INT8_MIN", "INTMAX_MAX", "INTMAX_MIN", "INTPTR_MAX", "INTPTR_MIN",
    "LINE_MAX", "LITTLE_ENDIAN", "LLONG_MAX", "LLONG_MIN", "LOGIN_NAME_MAX", "LONG_MAX", "LONG_MIN", "L_ctermid",
    "L_tmpnam", "MAX_CANON", "MAX_INPUT", "MB_CUR_MAX", "MB_LEN_MAX", "MILLION", "MQ_PRIO_MAX", "M_PI", "NAME_MAX",
    "NAN", "NEVER", "NEVER_MICROSTEP", "NEVER_TAG", "NEVER_TAG_INITIALIZER", "NFDBITS", "NGROUPS_MAX", "NULL",
    "PATH_MAX", "PDP_ENDIAN", "PIPE_BUF", "PTRDIFF_MAX", "PTRDIFF_MIN", "P_tmpdir", "RAND_MAX", "RE_DUP_MAX",
    "RTSIG_MAX", "SCHAR_MAX", "SCHAR_MIN", "SEM_VALUE_MAX", "SHRT_MAX", "SHRT_MIN", "SIG_ATOMIC_MAX",
    "SIG_ATOMIC_MIN", "SIZE_MAX", "SSIZE_MAX", "TIMER_ABSTIME", "TIME_UTC", "TMP_MAX", "TTY_NAME_MAX", "UCHAR_MAX",
    "UINTMAX_MAX", "UINTPTR_MAX", "ULLONG_MAX", "ULONG_MAX", "USHRT_MAX", "WCHAR_MAX", "WCHAR_MIN", "WCONTINUED",
    "WEXITED", "WINT_MAX", "WINT_MIN", "WNOHANG", "WNOWAIT", "WSTOPPED", "WUNTRACED", "XATTR_LIST_MAX",
    "XATTR_NAME_MAX", "XATTR_SIZE_MAX", "ZERO_TAG", "errno", "linux", "sched_priority", "stderr", "stdin", "stdout",
    "unix",
];

/// How the names of families of them begin.
const FAMILIES: [&str; 15] = [
    "CLOCK_",
    "INT_FAST",
    "INT_LEAST",
    "LF_",
    "LOG_LEVEL",
    "PRINTF_",
    "PTHREAD_",
    "SCHED_",
    "SEEK_",
    "UINT_FAST",
    "UINT_LEAST",
    "UINT16_M",
    "UINT32_M",
    "UINT64_M",
    "UINT8_M",
];

/// Whether a name stands for something else.
pub(super) fn is_macro(name: &str) -> bool {
    let is_format =
        |start| name.strip_prefix(start).is_some_and(|rest: &str| rest.starts_with(|c| "diouxX".contains(c)));
    let is_limit = ["INT_MAX", "INT_MIN", "UINT_MAX"].contains(&name);
    NAMES.binary_search(&name).is_ok()
        || FAMILIES.iter().any(|start| name.starts_with(start))
        || is_format("PRI")
        || is_format("SCN")
        || is_limit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn macros_are_found_and_other_names_are_not() {
        assert!(NAMES.is_sorted());
        for name in ["BUFSIZ", "linux", "EAGAIN", "PRId64", "UINT8_MAX", "INT_MAX", "NULL"] {
            assert!(is_macro(name), "{name}");
        }
        for name in ["x", "LIMIT", "PRIORITY", "EVENT", "max", "INTERVAL"] {
            assert!(!is_macro(name), "{name}");
        }
    }
}
