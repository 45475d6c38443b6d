#!/usr/bin/perl
# Between the clients and the daemon of README.md's and the help's session stands a recorder: what each request was answered, its
# status and its media type, is what openapi.yaml says; JSON has the members described. Our own client is one of them.
use strict;
use warnings;
use Cwd qw(abs_path);
use File::Temp qw(tempdir);
use FindBin;
use lib "$FindBin::Bin/../support";
use Contract;
use IO::Socket::INET;
use Recorder;
use Test::More;
use Vt;

my $contract = Contract->new;
my $session = join '', map { $_->{text} } grep { $_->{language} eq 'sh' } Vt::documented();
like $session, qr/^voronoid serve &$/m, 'README.md has a session';

# A port that was free a moment ago.
my $port = IO::Socket::INET->new(LocalAddr => '127.0.0.1', LocalPort => 0, Listen => 1)->sockport;
my $recorder = Recorder->start("127.0.0.1:$port");
my $url = "http://$recorder->{address}";
my $dir = tempdir(CLEANUP => 1);
mkdir "$dir/bin";
symlink abs_path($ENV{VORONOID} // 'build/release/voronoid'), "$dir/bin/voronoid";

my $own = <<"END";
voronoid health --server $url
voronoid resample cloud.ply -n 500 -q -o own.ply --server $url
voronoid inspect cloud.ply --json --server $url >inspect.json
! voronoid resample cloud.ply -n 0 -q -o none.ply --server $url
END
$session =~ s{http://127\.0\.0\.1:8080}{$url}g;
$session =~ s/^(?=kill %1)/$own/m or fail 'the session ends its daemon';
spew("$dir/cloud.ply", sphere_ply(4000));
spew("$dir/session.sh", "set -m\n$session\nwait\n");
my $status = system qq(cd $dir && VORONOID_LISTEN=127.0.0.1:$port XDG_STATE_HOME=$dir/state PATH=$dir/bin:\$PATH \\
    timeout 900 bash session.sh >out 2>err);
is $status, 0, 'the session ends well' or diag Vt::slurp("$dir/err");
$recorder->stop;
cmp_ok -s "$dir/own.ply", '>', 500 * 12, 'our own client has its result';

my @exchanges = $recorder->exchanges;
my %answered;
for my $exchange (@exchanges) {
    my ($operation, $route) = $contract->find(@$exchange{qw(method target)});
    $answered{ ($route // '') . " $exchange->{status}" }++;
    is_deeply [$contract->faults_of($exchange)], [], "$exchange->{method} $exchange->{target}: $exchange->{status}, "
        . ($exchange->{headers}{'content-type'} // 'no content');
}
ok $answered{$_}, "an answer to $_ was recorded" for 'GET /readyz 200', 'POST /v1/resample 200',
    'POST /v1/resample 201', 'POST /v1/resample 400', 'POST /v1/inspect 201', 'GET /v1/jobs/{jobID}/events 200',
    'GET /v1/jobs/{jobID}/results/{output} 200', 'DELETE /v1/jobs/{jobID} 200';

# The check can fail: the same answers, each with another status and another media type.
for my $exchange (grep { length $_->{body} } @exchanges) {
    my %headers = (%{ $exchange->{headers} }, 'content-type' => 'text/html');
    my @faults = ($contract->faults_of({ %$exchange, status => 418 }),
        $contract->faults_of({ %$exchange, headers => \%headers }));
    is scalar @faults, 2, "$exchange->{method} $exchange->{target}: 418 and text/html are no such answers";
}

sub spew {
    my ($path, $bytes) = @_;
    open my $file, '>:raw', $path or die "$path: $!";
    print $file $bytes;
    close $file or die "$path: $!";
}
done_testing;
