// SPDX-License-Identifier: Apache-2.0
// Colours for Lingua Franca in the site of the guide; highlight.js, which mdBook brings, does not know the language.
hljs.registerLanguage("lf", (library) => ({
  keywords: {
    keyword:
      "target import from preamble private public reactor main federated extends new at input output mutable state " +
      "reset timer logical physical action reaction mutation deadline tardy mode initial history watchdog method " +
      "const after interleaved serializer widthof",
    built_in: "startup shutdown time s sec ms msec us usec ns nsec min",
    literal: "true false forever never",
  },
  contains: [
    library.C_LINE_COMMENT_MODE,
    library.C_BLOCK_COMMENT_MODE,
    library.QUOTE_STRING_MODE,
    library.C_NUMBER_MODE,
    { className: "meta", begin: /@\w+/ },
    { begin: /\{=/, end: /=\}/, excludeBegin: true, excludeEnd: true, subLanguage: ["rust", "cpp"] },
  ],
}));
document.querySelectorAll("code.language-lf").forEach((code) => hljs.highlightBlock(code));
