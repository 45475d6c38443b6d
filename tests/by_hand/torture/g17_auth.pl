#!/usr/bin/perl
# Every route of the table by five kinds of key and three sources; identifiers of jobs; and which daemons do not start.
use strict;
use warnings;
use Cwd qw(abs_path);
use Digest::SHA qw(sha256_hex);
use File::Basename qw(dirname);
use File::Temp qw(tempdir);
use FindBin;
use Getopt::Long;
use lib "$FindBin::Bin/../../support";
use Vt;

my ($long, $seed) = (0, 1);
GetOptions('long' => \$long, 'seed=i' => \$seed) or exit 2;
my $dir = tempdir(CLEANUP => 1);
my %key = map { $_ => "secret-of-$_-0123456789abcdef" } qw(alice bob reader sender);

sub row { print join("\t", @_), "\n" }
sub verdict { return $_[0] ? 'ok' : 'short' }

my $file = "$dir/keys";
open my $out, '>', $file or die "$file: $!";
print $out "$_->[0]:$_->[1]:" . sha256_hex($key{ $_->[0] }) . ":rate=10000,jobs=1000\n"
    for ['alice', 'submit,read'], ['bob', 'submit,read'], ['reader', 'read'], ['sender', 'submit'];
close $out;
chmod 0600, $file;
my $daemon = Vt->start('api-keys' => $file);

sub make_job {
    my $made = $daemon->post('/v1/resample?points=50&iterations=2', sphere_ply(300), Authorization => "Bearer $key{alice}");
    die "no job: $made->{status} $made->{content}" if $made->{status} != 200;
    return $made->{headers}{location} =~ m{/([^/]+)$} ? $1 : die 'no job';
}

# --- the matrix -----------------------------------------------------------------------------------

my %lacking = (read => 'sender', submit => 'reader', admin => 'alice');
my %good_code = map { $_ => 1 } qw(200 201 202 204 400 409 422); # what a request without a body may get from a route
my ($cells, @wrong) = (0);
my (undef, undef, $printed) = Vt::run('--print-routes');
for my $line (split /\n/, $printed) {
    my ($method, $route, $scope) = split / /, $line;
    for my $who (qw(none bad other lacking good)) {
        for my $from (qw(here rebound foreign)) {
            my $job = $method eq 'DELETE' || !$main::job ? ($main::job = make_job()) : $main::job;
            my $path = $route =~ s/\{jobID\}/$job/r =~ s/\{slug\}/forbidden/r =~ s/\{processID\}/resample/r =~ s/\{output\}/cloud/r =~ s/\{asset\}/page.css/r;
            my $code = code_of($method, $path, $who, $scope, $from);
            $cells++;
            my $want = $from ne 'here' ? 403 : $scope eq 'open' ? undef : $who eq 'none' || $who eq 'bad' ? 401
                : $who eq 'lacking' ? 403 : $who eq 'other' && $route =~ /jobID/ ? 404 : $route =~ /preview$/ ? 404 : undef; # of a job that is over there is none
            push @wrong, "$method $route, key $who, from $from: $code" unless defined $want ? $code == $want : $good_code{$code};
            $main::job = undef if $method eq 'DELETE';
        }
    }
}
print STDERR "g17: $_\n" for @wrong;
row('G17', "cells of routes x keys x sources that are not as specified, of $cells", scalar @wrong, 0, verdict(!@wrong && $cells > 400));

sub code_of {
    my ($method, $path, $who, $scope, $from) = @_;
    my $name = { other => 'bob', good => 'alice', lacking => $lacking{$scope} // 'reader' }->{$who};
    my $head = "$method $path HTTP/1.1\r\nHost: " . ($from eq 'rebound' ? 'evil.example' : 'localhost') . "\r\n";
    $head .= "Origin: https://evil.example\r\n" if $from eq 'foreign';
    $head .= 'Authorization: Bearer ' . (defined $name ? $key{$name} : 'vor_nothing') . "\r\n" if $who ne 'none';
    my $raw = $daemon->raw("${head}Content-Length: 0\r\nConnection: close\r\n\r\n");
    return $raw =~ m{\AHTTP/1\.1 (\d+)} ? $1 : 0;
}
$daemon->stop;

# --- identifiers ----------------------------------------------------------------------------------

my $program = dirname(abs_path($ENV{VORONOID} // 'build/release/voronoid')) . '/tests/unit/callers_limits';
$program =~ s{^\Q@{[abs_path('.')]}\E/}{};
system('make', '-s', $program) unless -x $program;
my $ids = $long ? 1_000_000 : 200_000;
my $said = do { local $ENV{VT_IDS} = $ids; `$program 2>&1` };
my ($made, $repeated, $worst) = $said =~ /^# ids (\d+) repeated (\d+) worst chi-square ([\d.]+)$/m
    or die "$program does not tell of identifiers: $said";
row('G17', "identifiers that repeat, of $made", $repeated, 0, verdict($repeated == 0));
row('G17', 'chi-square of their random bytes, worst of 7, 255 degrees of freedom', $worst, 'below 400', verdict($worst < 400));

# --- who does not start ---------------------------------------------------------------------------

my $started = 0;
for my $wide (['--listen', '0.0.0.0:0'], ['--listen', '[::]:0'], ['--listen', '127.0.0.1:0', '--trusted-proxy', '127.0.0.1'],
    ['--listen', '127.0.0.1:0', '--public-url', 'https://cloud.example']) {
    my ($status) = Vt::run('--data', "$dir/none", @$wide);
    $started++ if $status != 2;
}
row('G17', 'daemons open to other machines, without keys or --no-auth, that do not end with 2, of 4', $started, 0, verdict($started == 0));
