"""One page that says in words, figures and plots what a diagnosis found."""

from morph.app.report.files import check_out as check_out
from morph.app.report.files import write_diagnosis as write_diagnosis
from morph.app.report.page import report_page as report_page
