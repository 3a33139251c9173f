"""What the table of faults promises, short of building each: tests/mutation/run does that."""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import table
import tap

FAULTS = table.load()


def test_there_are_thirty_faults_with_names_of_their_own():
    names = [fault["id"] for fault in FAULTS]
    assert len(names) >= 30 and len(set(names)) == len(names), sorted(names)


def test_every_fault_has_all_members_and_tests_that_exist():
    for fault in FAULTS:
        assert sorted(fault) == sorted(table.MEMBERS), fault["id"]
        assert fault["tests"], fault["id"]
        for test in fault["tests"]:
            assert os.path.exists(table.test_source(test)), f"{fault['id']}: no {test}"


def test_every_fault_applies_to_the_source_exactly_once():
    wrong = []
    for fault in FAULTS:
        try:
            table.mutate(fault)
        except ValueError as why:
            wrong.append(str(why))
    assert not wrong, wrong


def test_the_published_table_has_every_fault_and_no_survivor():
    with open(os.path.join(table.TOP, "docs/mutation/table.csv"), encoding="utf-8") as f:
        rows = dict(line.rstrip("\n").split(",", 2)[:2] for line in f.readlines()[1:])
    assert sorted(rows) == sorted(fault["id"] for fault in FAULTS)
    assert set(rows.values()) == {"caught"}, rows


if __name__ == "__main__":
    tap.main()
