#!/usr/bin/perl
# The whole test suite under AddressSanitizer with UBSan, and under ThreadSanitizer; lines and branches that it reaches; lint.
# Long form alone: the gate runs all but the coverage.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use Faults;

my %option = options();
exit 0 unless $option{long};
chdir "$FindBin::Bin/../../..";

# What a goal of make says, and whether it ended well.
sub goal {
    my ($goal) = @_;
    my @lines = qx{$goal 2>&1};
    my $is_well = $? == 0;
    print STDERR grep { /^not ok|Sanitizer|FAILED|error:/ } @lines;
    return $is_well, @lines;
}

my %run = (
    'AddressSanitizer and UBSan' => 'ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1 make config=asan check',
    ThreadSanitizer => 'TSAN_OPTIONS="halt_on_error=1 second_deadlock_stack=1" make config=tsan check',
);
for my $what (sort keys %run) {
    my ($is_well, @lines) = goal($run{$what});
    my ($files, $tests) = map { my $word = $_; (map { /$word=(\d+)/ ? $1 : () } @lines)[0] // '?' } qw(Files Tests);
    my $reports = grep { /(?:ERROR|WARNING): \w+Sanitizer|runtime error:/ } @lines;
    figure('G26', "$what: $files files, $tests tests: reports", $is_well ? $reports : "$reports, and tests fail", 0, $is_well && !$reports);
}
my ($is_well) = goal('make lint');
figure('G28', 'clang-tidy, cppcheck, gcc -fanalyzer, shellcheck, yamllint: findings', $is_well ? 0 : 'some', 0);

goal('make config=cover check');
my @total = map { /^TOTAL\s.*\s(\d+)%/ ? $1 : () } (
    qx{gcovr -r . --object-directory build/cover -f core/ -f proto/ -f server/ --exclude-throw-branches 2>/dev/null},
    qx{gcovr -r . --object-directory build/cover -f core/ -f proto/ -f server/ --exclude-throw-branches --branches 2>/dev/null});
my @reader = map { /^TOTAL\s.*\s(\d+)%/ ? $1 : () } (
    qx{gcovr -r . --object-directory build/cover -f proto/ply/ -f server/http/request_check -f server/work/sweeper 2>/dev/null},
    qx{gcovr -r . --object-directory build/cover -f proto/ply/ -f server/http/request_check -f server/work/sweeper --branches 2>/dev/null});
exit 1 unless @total == 2 && @reader == 2;
figure('G27', 'own C: lines that tests reach', "$total[0] %", '>= 95 %', $total[0] >= 95);
figure('G27', 'own C: branches', "$total[1] %", '>= 85 %', $total[1] >= 85);
figure('G27', 'PLY reader, gate, recovery: lines', "$reader[0] %", '100 %', $reader[0] == 100);
figure('G27', 'PLY reader, gate, recovery: branches', "$reader[1] %", '>= 95 %', $reader[1] >= 95);
