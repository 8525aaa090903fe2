"""Files that cannot be read, or not safely."""

from __future__ import annotations

from mrm_mtlx.findings.finding import Rule, Severity
from mrm_mtlx.system.limits import MAXIMUM_DOCUMENT_BYTES, MAXIMUM_INCLUDES, MAXIMUM_XML_DEPTH

READ_MISSING = Rule(
    "READ_MISSING",
    Severity.ERROR,
    "path does not exist",
    "A path on the command line names neither a file nor a folder.",
    "Check the spelling; paths are relative to the current folder.",
)

READ_FAILED = Rule(
    "READ_FAILED",
    Severity.ERROR,
    "file cannot be read",
    "The operating system refuses to read the file.",
    "Check the file's permissions, and that it is a file.",
)

READ_TOO_LARGE = Rule(
    "READ_TOO_LARGE",
    Severity.ERROR,
    "file is too large",
    f"The document, with what it includes, is larger than {MAXIMUM_DOCUMENT_BYTES // 2**20} MiB. A material is "
    "text of a few kilobytes; a file of this size is broken, or holds many materials that are better checked "
    "apart.",
    "Split the document; textures and geometry do not belong into it.",
)

READ_ENCODING = Rule(
    "READ_ENCODING",
    Severity.ERROR,
    "file is not UTF-8",
    "MaterialX documents are UTF-8 (MaterialX specification, section 'MTLX File Format Definition'). Other "
    "encodings are read by some programs as garbled names.",
    "Save the file as UTF-8.",
)

READ_XML = Rule(
    "READ_XML",
    Severity.ERROR,
    "file is not well-formed XML",
    "The XML parser stopped. Document type declarations are refused too: they can define entities that expand "
    "without bound or read other files, and MaterialX does not use them.",
    "Correct the line that is named; an empty file has no materialx element at all.",
)

READ_XML_LENIENT = Rule(
    "READ_XML_LENIENT",
    Severity.WARNING,
    "XML that only a lenient reader takes",
    'A value of an attribute has a "<" in it, as the examples of MaterialX\'s specification write <UDIM>. XML '
    "does not allow that (XML 1.0, section 2.3); MaterialX reads it, as it is read here, and other programs "
    "refuse the file.",
    "Write &lt; for it, as in &lt;UDIM>.",
)

READ_FORMAT = Rule(
    "READ_FORMAT",
    Severity.ERROR,
    "file is not what its name says",
    "The file's ending names a format (USD, glTF) that its content does not have: it is of another format, "
    "empty, cut short or damaged.",
    "Write the file anew with the program that it comes from, or give it the ending of what it holds.",
)

READ_TOO_DEEP = Rule(
    "READ_TOO_DEEP",
    Severity.ERROR,
    "elements are nested too deeply",
    f"XML elements are nested more than {MAXIMUM_XML_DEPTH} levels deep. MaterialX reads recursively and would "
    "exhaust the stack; real documents have fewer than ten levels.",
    "Flatten the document: nodes stand beside each other and are connected by name.",
)

READ_INCLUDE = Rule(
    "READ_INCLUDE",
    Severity.ERROR,
    "included file cannot be read",
    "A file that the document is made of (an xi:include of MaterialX, a buffer of glTF) does not exist; or it "
    "includes itself, directly or through others, as sublayers and references of USD can, too; or it takes "
    f"more than {MAXIMUM_INCLUDES} inclusions. Or something includes a file in a way that MaterialX passes "
    "over: an xi:include of another prefix or below another element, an include of a shader source that only "
    "the compiler behind it would resolve.",
    "Correct the name; break the circle; include files as MaterialX does.",
)

READ_OUTSIDE = Rule(
    "READ_OUTSIDE",
    Severity.ERROR,
    "file name points outside the folder",
    "An included document, an image or a shader source lies outside the folder that is being checked: the one "
    "that the command was given, or in which the document lies. Documents come from elsewhere, so nothing "
    "outside that folder, and of those named by `--root`, is opened.",
    "Move the file into the folder, or name the folder that holds it by --root.",
)
