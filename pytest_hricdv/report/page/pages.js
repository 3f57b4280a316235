// Views with plots and tables that are made when they are first opened: id -> function. Optional parts add theirs.

const PAGES = { suites: suitesPage, closure: closurePage, cross: crossPage };

// Further sections of a test's page, of what its details have: above and below what the person does.

const TEST_SECTIONS = { first: [], last: [] };
