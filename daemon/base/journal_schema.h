// journal_schema.h - the tables of the journal.
//
// A change of them is a new version and a step that leads to it from the one before.
//
// Thread-safety: constants.
#ifndef GLINT_BASE_JOURNAL_SCHEMA_H
#define GLINT_BASE_JOURNAL_SCHEMA_H

#define GLINT_JOURNAL_APPLICATION 0x676c6e74 // "glnt": PRAGMA application_id
#define GLINT_JOURNAL_VERSION 2              // PRAGMA user_version

// The forms of a revision's text.
enum glint_text_form {
    GLINT_TEXT_WHOLE, // data: the text
    GLINT_TEXT_FILE,  // in the vault, by the revision's id
    GLINT_TEXT_DELTA  // data: what differs from the text of `parent`
};

extern const char glint_journal_schema[], glint_journal_additions[];

#endif
