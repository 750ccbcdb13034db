"""Results for people: tables, pictures and a page of HTML, written without any library."""
